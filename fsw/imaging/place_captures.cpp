#include "fsw/imaging/place_captures.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/argument.hpp"
#include "fsw/shared/find.hpp"
#include "fsw/shared/local_plane.hpp"
#include "fsw/shared/measured_keyframe.hpp"
#include "fsw/shared/valid_store.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

// The wind turns: a straight line says nothing of a time that is much farther off than the places that it stands on.
constexpr TimeNs reach_in_spans = 4;
// Distances beyond are those of another side of the body, where the plane ends.
constexpr double farthest_m = 1e9;

struct Point {
  double x = 0, y = 0;
};
double dot(Point a, Point b) {
  return a.x * b.x + a.y * b.y;
}
Point from_to(Point a, Point b) {
  return {b.x - a.x, b.y - a.y};
}
double seconds_between(TimeNs from, TimeNs to) {
  return 1e-9 * static_cast<double>(to - from);
}

/// On the plane about the target.
Point offset_of(Body body, const PlaceTarget& target, const TrackPlace& place) {
  double offset_m[3] = {};
  plane_from_place(body, {target.longitude_deg, target.latitude_deg, 0}, {place.longitude_deg, place.latitude_deg, 0},
                   offset_m);
  return {offset_m[0], offset_m[1]};
}

/// x(t) = middle + velocity * (t - time), t in seconds since the newest place.
struct Line {
  Point middle, velocity;
  double time = 0;
  double spread = 0;       ///< sum of the squares of the times from their mean, s^2
  double variance_m2 = 0;  ///< of one place along each axis
};

Line line_through(Body body, const PlaceTrack& track, const PlaceTarget& target) {
  const auto n = static_cast<double>(track.places.size());
  const TimeNs newest = track.places.back().time_ns;
  FixedVector<Point, limits::max_track_places> points;
  Line line;
  for (const TrackPlace& place : track.places) {
    const Point point = offset_of(body, target, place);
    static_cast<void>(points.push_back(point));
    line.middle = {line.middle.x + point.x / n, line.middle.y + point.y / n};
    line.time += seconds_between(newest, place.time_ns) / n;
    line.variance_m2 += place.sigma_m * place.sigma_m / n;
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double t = seconds_between(newest, track.places[i].time_ns) - line.time;
    const Point way = from_to(line.middle, points[i]);
    line.velocity = {line.velocity.x + t * way.x, line.velocity.y + t * way.y};
    line.spread += t * t;
  }
  line.velocity = {line.velocity.x / line.spread, line.velocity.y / line.spread};
  double squares = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double t = seconds_between(newest, track.places[i].time_ns) - line.time;
    const Point way = from_to(line.middle, points[i]);
    const Point off{way.x - t * line.velocity.x, way.y - t * line.velocity.y};
    squares += dot(off, off);
  }
  if (n > 2) line.variance_m2 = std::max(line.variance_m2, squares / (2 * (n - 2)));
  return line;
}

/// Of the way from `a` to `b`, from the origin.
double nearest_on_way(Point a, Point b) {
  const Point way = from_to(a, b);
  const double length2 = dot(way, way);
  const double share = length2 > 0 ? std::clamp(-dot(a, way) / length2, 0.0, 1.0) : 0;
  const Point at{a.x + share * way.x, a.y + share * way.y};
  return std::sqrt(dot(at, at));
}

void note_distance(double distance_m, PlaceTarget& target) {
  if (!(distance_m < farthest_m)) return;
  if (target.nearest_m < 0 || distance_m < target.nearest_m) target.nearest_m = distance_m;
}

bool is_valid(const TrackPlace& place) {
  return place.longitude_deg >= -720 && place.longitude_deg <= 720 && place.latitude_deg >= -90 &&
         place.latitude_deg <= 90 && place.sigma_m > 0 && place.sigma_m < farthest_m;
}

void add_fix(Body body, const FixRecord& fix, const KeyframeRecord& keyframe, PlaceCaptures& state) {
  if (!(fix.place_sigma_m > 0) || fix.body != body) return;
  const BodyPlace at = place_from_plane(body, map_origin_of(fix), fix.place_m);
  add_place(body, {keyframe.time_ns, at.longitude_deg, at.latitude_deg, fix.place_sigma_m}, keyframe.strip_id,
            fix.map_id, state);
}

void add_position(Body body, const NavigationRecord& measured, const KeyframeRecord& keyframe, PlaceCaptures& state) {
  if (!has_place(measured, body)) return;
  add_place(body, {keyframe.time_ns, measured.longitude_deg, measured.latitude_deg, measured.horizontal_sigma_m},
            keyframe.strip_id, 0, state);
}

}  // namespace

Approach nearest_approach(Body body, const PlaceTrack& track, const PlaceTarget& target, TimeNs from_ns, TimeNs to_ns) {
  if (track.places.size() < 2 || to_ns < from_ns) return {};
  const TimeNs newest = track.places.back().time_ns, span = newest - track.places[0].time_ns;
  const TimeNs reach = newest + reach_in_spans * span;
  if (span <= 0 || from_ns > reach) return {};
  const Line line = line_through(body, track, target);
  const double speed2 = dot(line.velocity, line.velocity);
  const double from = seconds_between(newest, from_ns), to = seconds_between(newest, to_ns);
  const double nearest = speed2 > 0 ? line.time - dot(line.middle, line.velocity) / speed2 : from;
  const double t = std::clamp(nearest, from, to);
  if (!(t <= seconds_between(newest, reach))) return {};
  const double since = t - line.time;
  const Point at{line.middle.x + since * line.velocity.x, line.middle.y + since * line.velocity.y};
  Approach out;
  out.distance_m = std::sqrt(dot(at, at));
  if (!(out.distance_m < farthest_m)) return {};
  out.sigma_m = std::sqrt(line.variance_m2 * (1 + since * since / line.spread));
  out.time_ns = std::clamp(newest + static_cast<TimeNs>(std::floor(t * 1e9 + 0.5)), from_ns, to_ns);
  out.known = true;
  return out;
}

void add_place(Body body, const TrackPlace& place, std::int64_t strip_id, std::int64_t map_id, PlaceCaptures& state) {
  if (!is_valid(place)) return;
  PlaceTrack& track = state.track;
  if (track.strip_id != strip_id || track.map_id != map_id) track.places.clear();
  track.strip_id = strip_id;
  track.map_id = map_id;
  auto& places = track.places;
  if (!places.empty() && place.time_ns <= places.back().time_ns) return;
  for (PlaceTarget& target : state.targets) {
    if (place.time_ns < target.accepted_ns) continue;
    const Point end = offset_of(body, target, place);
    Point begin = end;
    if (!places.empty()) {
      // The way since the target was accepted.
      const TimeNs before = places.back().time_ns;
      const double share = target.accepted_ns <= before
                               ? 0
                               : seconds_between(before, target.accepted_ns) / seconds_between(before, place.time_ns);
      const Point start = offset_of(body, target, places.back()), way = from_to(start, end);
      begin = {start.x + share * way.x, start.y + share * way.y};
    }
    note_distance(nearest_on_way(begin, end), target);
  }
  if (places.full()) places.erase(0);
  static_cast<void>(places.push_back(place));
}

Result<bool> follow_place(Reader<FixRecord, NavigationRecord, KeyframeRecord> store, const MissionParameters& mission,
                          PlaceCaptures& state) {
  if (!has_places(mission)) return false;
  FixRecord fix;
  NavigationRecord measured;
  ILP_TAKE(const bool any, mission.use_map
                               ? find_next_valid<FixRecord>(store, state.track.keyframe_id, fix)
                               : find_next_valid<NavigationRecord>(store, state.track.keyframe_id, measured));
  if (!any) return false;
  state.track.keyframe_id = mission.use_map ? fix.id : measured.id;
  KeyframeRecord keyframe;
  ILP_TAKE(const bool known, find<KeyframeRecord>(store, state.track.keyframe_id, keyframe));
  if (!known) return true;
  if (mission.use_map && fix.map_id != 0) {
    add_fix(mission.body, fix, keyframe, state);
    return true;
  }
  bool given = !mission.use_map;
  if (!given && mission.use_navigation) {
    ILP_TAKE(given, find<NavigationRecord>(store, keyframe.id, measured));
  }
  if (given) add_position(mission.body, measured, keyframe, state);
  return true;
}

Status resume_track(Reader<FixRecord, NavigationRecord, KeyframeRecord> store, PlaceCaptures& state) {
  std::int64_t newest = 0;
  ILP_TRY(newest_id<KeyframeRecord>(store, newest));
  state = {};
  state.track.keyframe_id = std::max<std::int64_t>(newest - static_cast<std::int64_t>(limits::max_track_places), 0);
  return {};
}

Status accept_place(const CommandRecord& command, const MissionParameters& mission, TimeNs now, PlaceCaptures& state) {
  if (!has_places(mission)) return {StatusCode::places_unknown, static_cast<std::int64_t>(mission.body)};
  if (!(std::fabs(command.longitude_deg) <= 360)) return out_of_range(Argument::longitude, command.longitude_deg);
  if (!(std::fabs(command.latitude_deg) <= 90)) return out_of_range(Argument::latitude, command.latitude_deg);
  if (!(command.distance_m > 0 && command.distance_m < farthest_m)) {
    return out_of_range(Argument::place_distance, command.distance_m);
  }
  if (command.at_ns != 0 && command.at_ns < now) {
    return {StatusCode::capture_in_past, command.id, (now - command.at_ns) / ns_per_us};
  }
  const PlaceTarget target{.command_id = command.id,
                           .longitude_deg = command.longitude_deg,
                           .latitude_deg = command.latitude_deg,
                           .distance_m = command.distance_m,
                           .accepted_ns = now,
                           .limit_ns = command.at_ns};
  if (!state.targets.push_back(target)) {
    return {StatusCode::places_full, command.id, static_cast<std::int64_t>(state.targets.size())};
  }
  return {};
}

Status place_fault(Body body, const PlaceTrack& track, const PlaceTarget& target, TimeNs now) {
  PlaceTarget last = target;
  if (!track.places.empty()) {
    const TimeNs newest = track.places.back().time_ns;
    const Approach since =
        nearest_approach(body, track, target, std::max(newest, target.accepted_ns), std::max(newest, now));
    if (since.known) note_distance(since.distance_m, last);
  }
  if (last.nearest_m < 0) return {StatusCode::place_unseen, target.command_id};
  return {StatusCode::place_missed, target.command_id, static_cast<std::int64_t>(std::floor(last.nearest_m + 0.5))};
}

}  // namespace ilp
