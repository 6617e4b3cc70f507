#include "sim/world/truth.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <utility>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/host/colmap.hpp"
#include "sim/host/files.hpp"
#include "sim/host/image_io.hpp"
#include "sim/host/parallel.hpp"
#include "sim/world/height_grid.hpp"
#include "sim/world/visibility.hpp"

namespace ilp::world {
namespace fs = std::filesystem;
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

constexpr double least_overlap = 0.05;

std::string stem_of(const TruthSource& source, std::size_t k) {
  return fs::path(source.names[k]).stem().string();
}

TrueFrame load(const fs::path& dir, const TruthSource& source, std::size_t k, std::int32_t stride) {
  const fs::path path = dir / "depth" / (stem_of(source, k) + ".pfm");
  const host::Raster<float> depth = host::read_pfm(path);
  if (depth.width != source.camera.width || depth.height != source.camera.height) {
    throw std::runtime_error(path.string() + ": " + std::to_string(depth.width) + " x " + std::to_string(depth.height) +
                             " pixels; the camera has " + std::to_string(source.camera.width) + " x " +
                             std::to_string(source.camera.height));
  }
  return true_frame(source.camera, source.states[k].rotation, source.states[k].centre, depth.view(), stride);
}

void write_overlaps(const fs::path& path, const TruthSource& source, const std::vector<TrueFrame>& frames,
                    std::size_t threads) {
  std::vector<std::string> lines(frames.size());
  host::for_each_parallel(
      frames.size(),
      [&](std::size_t a) {
        for (std::size_t b = 0; b < frames.size(); ++b) {
          if (a == b) continue;
          const double overlap = true_overlap(frames[a], frames[b]);
          if (!(overlap > least_overlap)) continue;
          std::array<char, 64> numbers{};
          std::snprintf(numbers.data(), numbers.size(), ",%.6f,%.6f\n", overlap,
                        true_footprint_overlap(frames[a], frames[b]));
          lines[a] += stem_of(source, a) + "," + stem_of(source, b) + numbers.data();
        }
      },
      threads);
  std::ofstream out(path, std::ios::binary);
  out << "frame_a,frame_b,overlap,footprint\n";
  for (const std::string& text : lines) out << text;
  if (!out.flush()) throw std::runtime_error(path.string() + ": cannot be written: " + host::write_failure(errno));
}

void write_visible_before(const fs::path& dir, const TruthSource& source, const std::vector<TrueFrame>& frames,
                          std::size_t threads) {
  fs::create_directories(dir / "visible-before");
  host::for_each_parallel(
      frames.size(),
      [&](std::size_t k) {
        std::vector<const TrueFrame*> earlier;
        for (std::size_t i = 0; i < k; ++i) earlier.push_back(&frames[i]);
        const host::Raster<std::uint8_t> mask = visible_before_mask(load(dir, source, k, 1), earlier);
        host::write_png(dir / "visible-before" / (stem_of(source, k) + ".png"), mask.view());
      },
      threads);
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

void write_truth(const fs::path& dir, const TruthSource& source, std::size_t threads) {
  if (source.names.size() != source.states.size()) {
    throw std::invalid_argument("truth of " + std::to_string(source.states.size()) + " frames with " +
                                std::to_string(source.names.size()) + " names; expected one name per frame");
  }
  if (source.states.empty()) return;
  std::vector<TrueFrame> frames(source.states.size());
  const std::int32_t stride = sample_stride(source.camera);
  host::for_each_parallel(
      frames.size(), [&](std::size_t k) { frames[k] = load(dir, source, k, stride); }, threads);
  write_overlaps(dir / "overlap.csv", source, frames, threads);
  write_visible_before(dir, source, frames, threads);
  if (source.heights) write_height_grid(build_height_grid(frames, source.heights, {}, threads), dir);
  write_true_colmap_model(frames, source.names, dir / "colmap");
}

}  // namespace ilp::world
