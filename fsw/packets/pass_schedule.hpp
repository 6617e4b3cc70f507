// The times of contact with the ground: passes of equal length at equal intervals, or always.
#pragma once

#include "cfg/mission.hpp"
#include "fsw/base/time.hpp"

namespace ilp {

/// Without passes, mission time is divided into windows of this length, which replace passes.
inline constexpr TimeNs continuous_window_ns = 120 * ns_per_s;

struct Contact {
  bool open = false;
  bool over = false;      ///< there will be no further contact
  std::int64_t pass = 0;  ///< number of the pass, or of the next one while there is no contact
  TimeNs begin_ns = 0;    ///< of that pass
  TimeNs end_ns = 0;
};

/// Commands of the ground ([contact]) override the schedule of the mission parameters [downlink] pass_period_s (0:
/// always in contact), pass_length_s, pass_start_s, pass_count. A pass includes its first instant and excludes its end.
[[nodiscard]] Contact contact_at(const MissionParameters& mission, TimeNs now);

/// Time in contact within [from, to); 0 when `to` is not later.
[[nodiscard]] TimeNs contact_between(const MissionParameters& mission, TimeNs from, TimeNs to);

/// Begins a commanded pass, in addition to those of the schedule: sets [contact].
void open_contact(TimeNs now, double length_s, MissionParameters& mission);
/// Ends the present pass: no contact until the next one of the schedule begins (without passes: until the present
/// window has ended).
void close_contact(TimeNs now, MissionParameters& mission);

}  // namespace ilp
