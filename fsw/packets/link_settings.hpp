// The form of this flight's packets: APID, widths of fields and time code. It changes only at a start.
#pragma once

#include "cfg/mission.hpp"
#include "fsw/packets/tailoring.hpp"

namespace ilp {

struct LinkSettings {
  explicit LinkSettings(const MissionParameters& mission)
      : apid(mission.apid),
        tailoring(tailoring_of(mission.tailoring, mission.cuc_time, mission.agency_epoch_s)),
        time(mission.mission_epoch_s) {}

  std::uint16_t apid;
  Tailoring tailoring;
  MissionTime time;
};

}  // namespace ilp
