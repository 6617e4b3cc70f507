// Mission time of a flight in real time: begins with the flight, runs on through restarts, and is tied to UTC.
#pragma once

#include <cstdint>

#include "cfg/mission.hpp"
#include "fsw/base/time.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// Where mission time 0 lies.
enum class EpochChoice : std::uint8_t {
  first_start,  ///< the whole second of UTC before the flight's first start
  mission       ///< mission parameter mission_epoch_s
};

/// Sets `mission.mission_epoch_s`, and `now` to the mission time at `utc` (nanoseconds since 1958). A flight that was
/// begun keeps its epoch, which is a setting in its store. `time_out_of_range` (a = day, b = ns of mission time) when
/// the epoch is still to come: check the board's calendar clock.
Status begin_mission_time(Store& store, EpochChoice choice, std::int64_t utc, MissionParameters& mission, TimeNs& now);

/// The latest mission time that the store knows, 0 for an empty one: where virtual time goes on after a restart.
Status latest_known_time(Store& store, TimeNs& time);

}  // namespace ilp
