// Mission time of a flight in real time: begins with the flight, runs on through restarts, and is tied to UTC.
#pragma once

#include <cstdint>

#include "cfg/mission.hpp"
#include "fsw/base/time.hpp"
#include "fsw/shared/flight_memory.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// Where mission time 0 lies.
enum class EpochChoice : std::uint8_t {
  first_start,  ///< the whole second of UTC before the flight's first start
  mission       ///< mission parameter mission_epoch_s
};

struct MissionTimeBegin {
  TimeNs now = 0;
  Status news;  ///< clock_behind, or ok
};

/// Sets `mission.mission_epoch_s`, and tells the mission time at `utc` (nanoseconds since 1958). A flight that was
/// begun keeps its epoch, which is a setting in its store and in the small memory, also where its store is new. Mission
/// time never goes back: where the calendar clock is behind the latest known time, or before the epoch, it goes on from
/// the latest known time.
Status begin_mission_time(Store& store, FlightMemory& memory, EpochChoice choice, std::int64_t utc,
                          MissionParameters& mission, MissionTimeBegin& begin);

/// Mission time behind a calendar clock that was wrong at the start.
class LateCalendar {
 public:
  /// What begin_mission_time has told.
  void begin(const MissionTimeBegin& begin) { behind_ = !begin.news.ok(); }
  /// To be asked now and then: true when the calendar clock has come to be ahead of mission time, which is then to be
  /// set to `time`, forwards. `news` is the event of it.
  bool caught_up(std::int64_t utc, const MissionParameters& mission, TimeNs now, TimeNs& time, Status& news);

 private:
  bool behind_ = false;
};

/// The latest mission time that the store knows, 0 for an empty one: where virtual time goes on after a restart.
Status latest_known_time(Store& store, TimeNs& time);

}  // namespace ilp
