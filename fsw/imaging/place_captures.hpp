// Images at commanded places: where the vehicle goes by its latest places, and when it passes a place nearest.
#pragma once

#include "cfg/mission.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/result.hpp"
#include "fsw/records/records.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// Where a keyframe was taken; longitude east, latitude planetographic, both in degrees.
struct TrackPlace {
  TimeNs time_ns = 0;
  double longitude_deg = 0, latitude_deg = 0;
  double sigma_m = 0;  ///< one sigma to each side
};
/// The latest places of one strip, in order of time, all on one map or all by the vehicle's own positions.
struct PlaceTrack {
  FixedVector<TrackPlace, limits::max_track_places> places;
  std::int64_t strip_id = 0;
  std::int64_t map_id = 0;       ///< 0: positions of the vehicle
  std::int64_t keyframe_id = 0;  ///< keyframes up to it have been examined
};
/// A place of which an image is wanted.
struct PlaceTarget {
  std::int64_t command_id = 0;
  double longitude_deg = 0, latitude_deg = 0;
  double distance_m = 0;
  TimeNs accepted_ns = 0;
  TimeNs limit_ns = 0;    ///< 0: the end of the flight
  double nearest_m = -1;  ///< of the vehicle since it was accepted; -1: not known
};
struct PlaceCaptures {
  PlaceTrack track;
  FixedVector<PlaceTarget, limits::max_place_captures> targets;
};

/// The vehicle nearest to a target.
struct Approach {
  bool known = false;
  TimeNs time_ns = 0;
  double distance_m = 0;
  double sigma_m = 0;  ///< of the place of the vehicle at that time, to each side

  /// Two sigma in favour of the image.
  [[nodiscard]] bool within(double most_m) const { return known && distance_m <= most_m + 2 * sigma_m; }
};

/// The closest approach from `from_ns` to `to_ns`, by the straight line of least squares through the places. Its error
/// is that of one place, stated or by the scatter about the line, whichever is larger: errors of neighbours are alike,
/// so their mean errs like one of them; the error of the slope is added. Unknown with fewer than two places, and where
/// it is later after the newest place than four times the time from the first to the newest.
[[nodiscard]] Approach nearest_approach(Body body, const PlaceTrack& track, const PlaceTarget& target, TimeNs from_ns,
                                        TimeNs to_ns);

/// A new place of the vehicle, which lies in strip `strip_id` and on map `map_id` (0: by the vehicle). Another strip or
/// map begins the track again; a place that is not later than the newest one is left out. The targets learn how near
/// the vehicle has come on the straight way from the place before.
void add_place(Body body, const TrackPlace& place, std::int64_t strip_id, std::int64_t map_id, PlaceCaptures& state);

/// The next keyframe whose place is on record: by the latest fixes on the map (record `fix`), or, where there is no
/// map, by the vehicle (record `navigation`). Whether there was one; a keyframe without a place counts.
[[nodiscard]] Result<bool> follow_place(Reader<FixRecord, NavigationRecord, KeyframeRecord> store,
                                        const MissionParameters& mission, PlaceCaptures& state);

/// Behind a lost checkpoint the track begins with the latest keyframes.
[[nodiscard]] Status resume_track(Reader<FixRecord, NavigationRecord, KeyframeRecord> store, PlaceCaptures& state);

/// Errors: places_unknown; invalid_argument (a record that no telecommand made); capture_in_past (its time is over);
/// places_full.
[[nodiscard]] Status accept_place(const CommandRecord& command, const MissionParameters& mission, TimeNs now,
                                  PlaceCaptures& state);

/// Why a target was abandoned: place_missed with the nearest approach in metres, or place_unseen.
[[nodiscard]] Status place_fault(Body body, const PlaceTrack& track, const PlaceTarget& target, TimeNs now);

}  // namespace ilp
