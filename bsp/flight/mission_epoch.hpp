// Finds mission time at the start of a flight in real time. Mission time begins with the flight, continues through
// restarts, and is tied to UTC.
#pragma once

#include <cstdint>

#include "cfg/mission.hpp"
#include "fsw/base/time.hpp"
#include "fsw/shared/flight_memory.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// The instant of mission time 0.
enum class EpochChoice : std::uint8_t {
  first_start,  ///< the last full second of UTC before the flight's first start
  mission       ///< the mission parameter mission_epoch_s
};

struct MissionTimeBegin {
  TimeNs now = 0;  ///< mission time at the start
  /// `clock_behind`, `time_out_of_range` (first value: days since 1958, second: s of mission time), or ok.
  Status updates;
};

/// Sets `mission.mission_epoch_s`, and `begin` to the mission time at `utc` (ns since 1958). An existing flight keeps
/// its epoch, which is a setting in its store and in the nonvolatile memory; this holds for a new store too. Mission
/// time never goes back. It continues from the latest known time if the calendar clock is before that time or before
/// the epoch, or if mission time would exceed longest_duration_ns.
Status begin_mission_time(Store& store, FlightMemory& memory, EpochChoice choice, std::int64_t utc,
                          MissionParameters& mission, MissionTimeBegin& begin);

/// Corrects mission time when a calendar clock that was wrong at the start has been set.
class LateCalendar {
 public:
  /// `begin` is the result of begin_mission_time().
  void begin(const MissionTimeBegin& begin) { behind_ = !begin.updates.ok(); }
  /// Call it regularly with the present UTC and mission time. Returns true once, when UTC is ahead of mission time. The
  /// caller must then set mission time to `time` and report the event `updates`.
  bool caught_up(std::int64_t utc, const MissionParameters& mission, TimeNs now, TimeNs& time, Status& updates);

 private:
  bool behind_ = false;
};

/// Finds the latest mission time in the store; 0 for an empty store. Virtual time continues from it after a restart.
Status latest_known_time(Store& store, TimeNs& time);

}  // namespace ilp
