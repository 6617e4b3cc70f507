#include "sim/tools/score/track_score.hpp"

#include <cmath>
#include <optional>
#include <vector>

#include "sim/host/statistics.hpp"

namespace ilp::score {
namespace {

constexpr int points_across = 12, points_down = 9;

/// A keyframe with depths that came down.
struct Segment {
  const host::Raster<float>* inverse_depth = nullptr;
  const world::TrueFrame* frame = nullptr;
  double scale = 1;  ///< true lengths in one unit of its strip
};

struct Seen {
  double distance = 0, relative_error = 0;
};

std::optional<Seen> seen_in(const Segment& segment, const Vec3& point) {
  const Vec3 &low = segment.frame->low, &high = segment.frame->high;
  if (point.x() < low.x() || point.x() > high.x() || point.y() < low.y() || point.y() > high.y()) return std::nullopt;
  Vec2 pixel;
  double depth = 0;
  if (!world::project(*segment.frame, point, pixel, depth) || !world::sees(*segment.frame, point)) return std::nullopt;
  const float inverse = segment.inverse_depth->at(static_cast<std::int32_t>(std::lround(pixel.x())),
                                                  static_cast<std::int32_t>(std::lround(pixel.y())));
  if (!(inverse > 0)) return std::nullopt;
  return Seen{depth, std::fabs(segment.scale / static_cast<double>(inverse) / depth - 1)};
}

std::optional<Seen> finest(const std::vector<Segment>& segments, const Vec3& point) {
  std::optional<Seen> best;
  for (const Segment& segment : segments) {
    const std::optional<Seen> seen = seen_in(segment, point);
    if (seen && (!best || seen->distance < best->distance)) best = seen;
  }
  return best;
}

struct Point {
  Vec3 ground;
  double distance = 0;
};

std::vector<Point> inner_points(const world::TrueFrame& frame) {
  std::vector<Point> points;
  for (int j = 0; j < points_down; ++j) {
    for (int i = 0; i < points_across; ++i) {
      const auto column = static_cast<std::size_t>(frame.columns * (points_across + 2 * i + 1) / (4 * points_across));
      const auto row = static_cast<std::size_t>(frame.rows * (points_down + 2 * j + 1) / (4 * points_down));
      const std::size_t sample = row * static_cast<std::size_t>(frame.columns) + column;
      const double distance = frame.depth[sample];
      if (distance > 0 && std::isfinite(distance)) points.push_back({frame.ground[sample], distance});
    }
  }
  return points;
}

}  // namespace

TrackScore score_track(const intake::Flight& flight, const std::map<std::int64_t, AlignedStrip>& strips,
                       TrueFrames& truth) {
  std::vector<Segment> segments;
  std::vector<const world::TrueFrame*> track;
  for (const auto& [id, keyframe] : flight.keyframes) {
    const auto strip = strips.find(keyframe.strip_id);
    if (!keyframe.posed() || strip == strips.end()) continue;
    const world::TrueFrame* frame = truth.sampled(keyframe.name);
    if (frame == nullptr) continue;
    track.push_back(frame);
    if (keyframe.inverse_depth.same_size(keyframe.camera.width, keyframe.camera.height)) {
      segments.push_back({&keyframe.inverse_depth, frame, strip->second.true_from_strip.scale});
    }
  }
  TrackScore score;
  std::vector<double> errors, ratios;
  for (const world::TrueFrame* frame : track) {
    for (const Point& point : inner_points(*frame)) {
      ++score.points;
      const std::optional<Seen> seen = finest(segments, point.ground);
      if (!seen) continue;
      ++score.mapped;
      errors.push_back(100 * seen->relative_error);
      if (frame == track.back()) ratios.push_back(seen->distance / point.distance);
    }
  }
  if (!errors.empty()) score.error_median_percent = host::median(std::move(errors));
  if (!ratios.empty()) score.landing_ratio = host::median(std::move(ratios));
  return score;
}

}  // namespace ilp::score
