#include "fsw/vision/multiview/sequence_tracks.hpp"

#include <array>
#include <cmath>

#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/twoview/solvers/triangulation.hpp"

namespace ilp {
namespace {

// Observations above it are dropped from their track.
constexpr double max_reprojection_px = 2.0;
// Between two rays of a new point.
constexpr double min_triangulation_angle_rad = 0.01;

Vec2 ideal_of(const CameraModel& camera, const Corner& corner) {
  return ideal_from_pixel(camera, Vec2(corner.x, corner.y));
}

Vec3 position_of(const Track& track) {
  return {track.position[0], track.position[1], track.position[2]};
}

void set_position(Track& track, const Vec3& x) {
  for (int k = 0; k < 3; ++k) track.position[k] = x[k];
}

/// Distance in px between the projection of `x` and an observation; huge behind the camera.
double reprojection_error(const CameraModel& camera, const RigidTransform& pose, const Vec3& x, double u, double v) {
  const Vec3 p = pose * x;
  if (!(p.z() > 0)) return 1e150;
  const double du = camera.fx * (p.x() / p.z()) + camera.cx - u;
  const double dv = camera.fy * (p.y() / p.z()) + camera.cy - v;
  return std::sqrt(du * du + dv * dv);
}

struct CameraTransforms {
  explicit CameraTransforms(const SequenceState& state) {
    for (std::size_t i = 0; i < state.cameras.size(); ++i) at[i] = cam_from_world(state.cameras[i].pose);
  }
  std::array<RigidTransform, limits::max_bundle_cameras> at;
};

}  // namespace

/// Fills w_.track_of_corner for the corners of the base. Returns how many corners there are.
std::size_t SequenceTracks::map_base() {
  if (s_.back > 0) return list_corners(s_.tracks, newest() - s_.back, w_.track_of_corner);
  map_corners(s_.tracks, newest(), w_.track_of_corner);
  return s_.corners.size();
}

/// Ideal px. It holds after map_base() until a camera is added.
Vec2 SequenceTracks::seen_from_base(const Match& match) const {
  if (s_.back == 0) {
    const Corner& corner = s_.corners[match.a];
    return ideal_from_pixel(s_.camera, Vec2(static_cast<double>(corner.x), static_cast<double>(corner.y)));
  }
  const Track& track = s_.tracks[w_.track_of_corner[match.a]];
  const std::uint32_t k = newest() - s_.back - track.first;
  return {static_cast<double>(track.x[k]), static_cast<double>(track.y[k])};
}

void SequenceTracks::corners_of(std::uint32_t back, Corners& corners) const {
  const std::uint32_t ordinal = newest() - back;
  corners.clear();
  const std::size_t count = list_corners(s_.tracks, ordinal, w_.track_of_corner);
  for (std::size_t i = 0; i < count; ++i) {
    const Track& track = s_.tracks[w_.track_of_corner[i]];
    const std::uint32_t k = ordinal - track.first;
    const Vec2 pixel =
        pixel_from_ideal(s_.camera, Vec2(static_cast<double>(track.x[k]), static_cast<double>(track.y[k])));
    (void)corners.push_back({static_cast<float>(pixel.x()), static_cast<float>(pixel.y()), 0});
  }
}

std::size_t SequenceTracks::count_corners(std::uint32_t back) const {
  return list_corners(s_.tracks, newest() - back, w_.track_of_corner);
}

void SequenceTracks::fill_pairs() {
  if (s_.back > 0) (void)map_base();
  w_.pairs.clear();
  for (const Match& m : s_.matches) {
    const Vec2 a = seen_from_base(m);
    const Vec2 b = ideal_of(s_.camera, s_.new_corners[m.b]);
    (void)w_.pairs.push_back({a.x(), a.y(), b.x(), b.y(), m.score});
  }
}

void SequenceTracks::collect_known_points() {
  w_.views.clear();
  for (std::size_t i = 0; i < s_.matches.size(); ++i) {
    w_.contradicts[i] = 0;
    const Match& m = s_.matches[i];
    const std::uint16_t t = w_.track_of_corner[m.a];
    if (s_.related[i] == 0 || t == no_track || s_.tracks[t].phase != TrackPhase::point) continue;
    const Track& track = s_.tracks[t];
    const Vec2 b = ideal_of(s_.camera, s_.new_corners[m.b]);
    w_.match_of_view[w_.views.size()] = static_cast<std::uint16_t>(i);
    (void)w_.views.push_back({{track.position[0], track.position[1], track.position[2]}, b.x(), b.y()});
  }
}

void SequenceTracks::extend() {
  const std::uint32_t now = newest();
  std::size_t begun = 0;
  for (std::size_t i = 0; i < s_.matches.size(); ++i) {
    const Match& m = s_.matches[i];
    if (s_.related[i] == 0 || w_.contradicts[i] != 0) continue;
    const std::uint16_t t = w_.track_of_corner[m.a];
    if (t == no_track) {
      w_.match_of_view[begun++] = static_cast<std::uint16_t>(i);
      continue;
    }
    const Vec2 b = ideal_of(s_.camera, s_.new_corners[m.b]);
    miss_until(s_.tracks[t], now);
    ilp::extend(s_.tracks[t], m.b, b.x(), b.y());
  }
  for (Track& track : s_.tracks) {
    if (end_of(track) == now + 1) continue;
    track.growing = false;
    if (track.phase == TrackPhase::open && s_.first_pair.begun) track.phase = TrackPhase::removed;
  }
  compact(s_.tracks);
  if (Tracks::capacity() - s_.tracks.size() < begun) s_.report.evicted_tracks = make_room(s_.tracks, begun);
  for (std::size_t n = 0; n < begun; ++n) {
    const Match& m = s_.matches[w_.match_of_view[n]];
    const Vec2 a = ideal_of(s_.camera, s_.corners[m.a]);
    const Vec2 b = ideal_of(s_.camera, s_.new_corners[m.b]);
    Track track = begin_track(now - 1, m.a, a.x(), a.y());
    ilp::extend(track, m.b, b.x(), b.y());
    if (!s_.tracks.push_back(track)) ++s_.report.refused_tracks;
  }
}

Status SequenceTracks::triangulate() {
  const CameraTransforms cameras(s_);
  for (Track& track : s_.tracks) {
    if (track.phase != TrackPhase::open || track.count < 2) continue;
    std::array<RayView, limits::max_track_length> views;
    std::uint32_t count = 0;
    for (std::uint32_t k = 0; k < track.count; ++k) {
      const std::size_t camera = track.first + k - s_.oldest;
      if (!s_.cameras[camera].posed || !sees(track, track.first + k)) continue;
      views[count].normalised = normalised_from_ideal(s_.camera, Vec2(track.x[k], track.y[k]));
      views[count].cam_from_world = cameras.at[camera];
      ++count;
    }
    if (count < 2) continue;
    TriangulatedPoint point;
    const Status status = ilp::triangulate(views.data(), count, point);
    // Rays that are still too parallel wait for a wider baseline; rays that do not meet come from a wrong match.
    if (!status.ok() || point.angle_rad < min_triangulation_angle_rad) continue;
    if (!point.in_front || point.max_error * focal_px() > max_reprojection_px) {
      track.phase = TrackPhase::removed;
      continue;
    }
    set_position(track, point.position);
    track.phase = TrackPhase::point;
    ++s_.report.new_points;
  }
  compact(s_.tracks);
  s_.phase = SequencePhase::adjust;
  return {};
}

Status SequenceTracks::prune() {
  const CameraTransforms cameras(s_);
  for (Track& track : s_.tracks) {
    if (track.phase != TrackPhase::point) continue;
    for (std::uint32_t k = 0; k < track.count; ++k) {
      if (!uses(track, k)) continue;
      const RigidTransform& pose = cameras.at[track.first + k - s_.oldest];
      if (reprojection_error(s_.camera, pose, position_of(track), track.x[k], track.y[k]) <= max_reprojection_px) {
        continue;
      }
      track.used = static_cast<std::uint16_t>(track.used & ~(1U << k));
      ++s_.report.dropped_observations;
      // If the last match was wrong, its corner belongs to another point.
      if (k + 1U == track.count) track.growing = false;
    }
    if (used_count(track) < 2) {
      track.phase = TrackPhase::removed;
      ++s_.report.lost_points;
    }
  }
  compact(s_.tracks);
  const bool again = s_.report.dropped_observations > 0;
  s_.phase = again ? SequencePhase::readjust : SequencePhase::conclude;
  return {};
}

void SequenceTracks::finish() {
  const CameraTransforms cameras(s_);
  for (Track& track : s_.tracks) {
    if (end_of(track) > s_.final_count || track.phase == TrackPhase::removed) continue;
    track.growing = false;
    bool good = track.phase == TrackPhase::point && used_count(track) >= 2;
    for (std::uint32_t k = 0; good && k < track.count; ++k) {
      const RigidTransform& pose = cameras.at[track.first + k - s_.oldest];
      good = !uses(track, k) ||
             reprojection_error(s_.camera, pose, position_of(track), track.x[k], track.y[k]) <= max_reprojection_px;
    }
    if (track.phase == TrackPhase::point && !good) ++s_.report.lost_points;
    track.phase = good ? TrackPhase::final_point : TrackPhase::removed;
  }
  s_.point_cursor = 0;
}

bool SequenceTracks::take_final_point(FinalPoint& point) {
  for (; s_.point_cursor < s_.tracks.size(); ++s_.point_cursor) {
    Track& track = s_.tracks[s_.point_cursor];
    if (track.phase != TrackPhase::final_point) continue;
    point = {};
    double sum = 0;
    for (int k = 0; k < 3; ++k) point.position[k] = track.position[k];
    for (std::uint32_t k = 0; k < track.count; ++k) {
      if (!uses(track, k)) continue;
      const SequenceCamera& camera = s_.cameras[track.first + k - s_.oldest];
      const double error =
          reprojection_error(s_.camera, cam_from_world(camera.pose), position_of(track), track.x[k], track.y[k]);
      sum += error * error;
      (void)point.observations.push_back({camera.keyframe_id, track.x[k], track.y[k]});
    }
    point.error_px = static_cast<float>(std::sqrt(sum / static_cast<double>(point.observations.size())));
    track.phase = TrackPhase::removed;
    ++s_.point_cursor;
    return true;
  }
  return false;
}

}  // namespace ilp
