// The times of contact with the ground: passes of equal length at equal intervals, or always.
#pragma once

#include "cfg/mission.hpp"
#include "fsw/base/time.hpp"

namespace ilp {

/// If the mission has no passes, mission time is divided into windows of this length, which are numbered like passes.
inline constexpr TimeNs continuous_window_ns = 120 * ns_per_s;

struct Contact {
  bool open = false;
  bool over = false;      ///< the schedule has no further pass
  std::int64_t pass = 0;  ///< number of the present pass, from 0; without contact, of the next pass
  TimeNs begin_ns = 0;    ///< begin and end of the present contact, or of that next pass
  TimeNs end_ns = 0;
};

/// Returns the state of contact at mission time `now`. The schedule is given by the mission parameters [downlink]
/// pass_period_s (0: always in contact), pass_length_s, pass_start_s and pass_count. Commands of the ground ([contact])
/// override it. A pass includes its first instant and excludes its end.
[[nodiscard]] Contact contact_at(const MissionParameters& mission, TimeNs now);

/// Time in contact within [from, to); 0 when `to` is not later.
[[nodiscard]] TimeNs contact_between(const MissionParameters& mission, TimeNs from, TimeNs to);

/// Begins a commanded pass, in addition to those of the schedule. Sets [contact] of `mission`.
void open_contact(TimeNs now, double length_s, MissionParameters& mission);
/// Ends the present pass: there is no contact until the next pass of the schedule begins, or, without passes, until the
/// present window ends. Sets [contact] of `mission`.
void close_contact(TimeNs now, MissionParameters& mission);

}  // namespace ilp
