#include "sim/world/truth_colmap.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/host/colmap_camera.hpp"
#include "sim/host/colmap_text.hpp"

namespace ilp::world {
namespace {

constexpr std::int32_t candidates_per_row = 24;

void add_point(std::span<const TrueFrame> frames, std::size_t first, const Vec3& position, host::ColmapText& model) {
  std::vector<std::pair<std::size_t, Vec2>> seen;
  for (std::size_t k = first; k < frames.size(); ++k) {
    Vec2 pixel;
    double depth = 0;
    if (sees(frames[k], position) && project(frames[k], position, pixel, depth)) seen.emplace_back(k, pixel);
  }
  if (seen.size() < 2) return;
  host::ColmapPoint point;
  point.position = position;
  for (const auto& [frame, pixel] : seen) {
    std::vector<host::ColmapObservation>& observations = model.views[frame].seen;
    point.track.emplace_back(model.views[frame].id, observations.size());
    observations.push_back({pixel.x(), pixel.y(), model.points.size()});
  }
  model.points.push_back(std::move(point));
}

host::ColmapView view_of(std::int64_t id, const TrueFrame& frame, const std::string& name) {
  double q[4];
  quaternion_from_rotation(frame.cam_from_world, q);
  return {id, {q[0], q[1], q[2], q[3]}, -(frame.cam_from_world * frame.centre), name, {}};
}

host::ColmapText build(std::span<const TrueFrame> frames, const std::vector<std::string>& names) {
  host::ColmapText model;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    model.views.push_back(view_of(static_cast<std::int64_t>(k + 1), frames[k], names[k]));
  }
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const TrueFrame& frame = frames[k];
    const std::int32_t step = std::max(1, frame.columns / candidates_per_row);
    for (std::int32_t j = step / 2; j < frame.rows; j += step) {
      for (std::int32_t i = step / 2; i < frame.columns; i += step) {
        const Vec3& position = frame.ground[frame.index(i, j)];
        const auto earlier = frames.first(k);
        const bool known = std::any_of(earlier.rbegin(), earlier.rend(),
                                       [&](const TrueFrame& other) { return sees(other, position); });
        if (position.allFinite() && !known) add_point(frames, k, position, model);
      }
    }
  }
  return model;
}

}  // namespace

void write_true_colmap_model(std::span<const TrueFrame> frames, const std::vector<std::string>& names,
                             const std::filesystem::path& folder) {
  if (frames.empty() || frames.size() != names.size()) {
    throw std::invalid_argument("a model of " + std::to_string(frames.size()) + " frames with " +
                                std::to_string(names.size()) + " names; expected as many, and at least one");
  }
  std::filesystem::create_directories(folder);
  host::write_colmap_camera(folder / "cameras.txt", frames.front().camera);
  host::write_colmap_text(build(frames, names), folder);
}

}  // namespace ilp::world
