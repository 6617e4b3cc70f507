// Images at commanded places: extrapolates the vehicle's latest positions and finds when it is nearest to a place.
#pragma once

#include "cfg/mission.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/result.hpp"
#include "fsw/records/records.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// The position at which a keyframe was taken. The longitude is positive to the east, the latitude planetographic.
struct TrackPlace {
  TimeNs time_ns = 0;
  double longitude_deg = 0, latitude_deg = 0;
  double sigma_m = 0;  ///< standard deviation per axis
};
/// The latest positions in one strip, in order of time. All are from fixes on one map, or all from the vehicle.
struct PlaceTrack {
  FixedVector<TrackPlace, limits::max_track_places> places;
  std::int64_t strip_id = 0;
  std::int64_t map_id = 0;       ///< 0: positions from the vehicle
  std::int64_t keyframe_id = 0;  ///< keyframes up to this one have been examined
};
/// A place of which an image is wanted.
struct PlaceTarget {
  std::int64_t command_id = 0;
  double longitude_deg = 0, latitude_deg = 0;
  double distance_m = 0;  ///< the largest distance at which an image is wanted
  TimeNs accepted_ns = 0;
  TimeNs limit_ns = 0;    ///< the target is abandoned then; 0: at the end of the flight
  double nearest_m = -1;  ///< smallest distance of the vehicle since the target was accepted; -1: not known
};
struct PlaceCaptures {
  PlaceTrack track;
  FixedVector<PlaceTarget, limits::max_place_captures> targets;
};

/// The closest approach of the vehicle to a target.
struct Approach {
  bool known = false;
  TimeNs time_ns = 0;
  double distance_m = 0;
  double sigma_m = 0;  ///< standard deviation of the vehicle's position at that time, per axis

  /// Whether the distance is at most `most_m`, with a tolerance of two sigma.
  [[nodiscard]] bool within(double most_m) const { return known && distance_m <= most_m + 2 * sigma_m; }
};

/// The closest approach between `from_ns` and `to_ns`, on the straight line of least squares through the positions. Its
/// error is that of one position plus that of the slope. The error of one position is the larger one of its sigma and
/// the scatter about the line; it is not divided by the number of positions, because their errors are correlated. The
/// result is unknown with fewer than two positions, or if the approach is later after the newest position than four
/// times the duration of the track.
[[nodiscard]] Approach nearest_approach(Body body, const PlaceTrack& track, const PlaceTarget& target, TimeNs from_ns,
                                        TimeNs to_ns);

/// Adds a position of the vehicle in strip `strip_id`, from a fix on map `map_id` (0: from the vehicle). Another strip
/// or map starts the track again. A position that is not later than the newest one is left out. Updates the smallest
/// distances of the targets on the straight line from the position before.
void add_place(Body body, const TrackPlace& place, std::int64_t strip_id, std::int64_t map_id, PlaceCaptures& state);

/// Adds the position of the next keyframe from its record `fix`, or, if there is no map, from its record `navigation`.
/// Returns whether there was a next keyframe, even if it has no position.
[[nodiscard]] Result<bool> follow_place(Reader<FixRecord, NavigationRecord, KeyframeRecord> store,
                                        const MissionParameters& mission, PlaceCaptures& state);

/// After a lost checkpoint: starts the track with the latest keyframes.
[[nodiscard]] Status resume_track(Reader<FixRecord, NavigationRecord, KeyframeRecord> store, PlaceCaptures& state);

/// Adds the target of a command. Returns `places_unknown` if the flight has no positions, `invalid_argument` for a
/// command with invalid values, `capture_in_past` if its time limit is over, and `places_full` if there are too many
/// targets.
[[nodiscard]] Status accept_place(const CommandRecord& command, const MissionParameters& mission, TimeNs now,
                                  PlaceCaptures& state);

/// The reason why a target was abandoned: `place_missed` with the smallest distance in metres, or `place_unseen` if no
/// distance is known.
[[nodiscard]] Status place_fault(Body body, const PlaceTrack& track, const PlaceTarget& target, TimeNs now);

}  // namespace ilp
