// Mission time of a flight in real time: it begins with the flight, continues through restarts, and is tied to UTC.
#pragma once

#include <cstdint>

#include "cfg/mission.hpp"
#include "fsw/base/time.hpp"
#include "fsw/shared/flight_memory.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// The instant of mission time 0.
enum class EpochChoice : std::uint8_t {
  first_start,  ///< the whole second of UTC before the flight's first start
  mission       ///< mission parameter mission_epoch_s
};

struct MissionTimeBegin {
  TimeNs now = 0;
  Status updates;  ///< clock_behind; time_out_of_range (a = day since 1958, b = s of mission time); or ok
};

/// Sets `mission.mission_epoch_s`, and returns the mission time at `utc` (nanoseconds since 1958). An existing flight
/// keeps its epoch, which is a setting in its store and in the nonvolatile memory, also if its store is new. Mission
/// time never goes back: if the calendar clock is before the latest known time, or before the epoch, mission time
/// continues from the latest known time. It does so too if the calendar is later than mission time can be
/// (longest_duration_ns).
Status begin_mission_time(Store& store, FlightMemory& memory, EpochChoice choice, std::int64_t utc,
                          MissionParameters& mission, MissionTimeBegin& begin);

/// Corrects mission time when a calendar clock that was wrong at the start becomes right.
class LateCalendar {
 public:
  /// Takes the result of begin_mission_time.
  void begin(const MissionTimeBegin& begin) { behind_ = !begin.updates.ok(); }
  /// Call it regularly. True when the calendar clock is ahead of mission time, which must then be set forwards to
  /// `time`. `updates` is the event for it.
  bool caught_up(std::int64_t utc, const MissionParameters& mission, TimeNs now, TimeNs& time, Status& updates);

 private:
  bool behind_ = false;
};

/// The latest mission time in the store, 0 for an empty one. Virtual time continues from it after a restart.
Status latest_known_time(Store& store, TimeNs& time);

}  // namespace ilp
