#include "sim/world/truth.hpp"

#include <array>
#include <cstdio>
#include <fstream>
#include <stdexcept>

#include "sim/host/image_io.hpp"
#include "sim/host/parallel.hpp"
#include "sim/world/height_grid.hpp"
#include "sim/world/truth_colmap.hpp"
#include "sim/world/visibility.hpp"

namespace ilp::world {
namespace fs = std::filesystem;
namespace {

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
  if (!out.flush()) throw std::runtime_error(path.string() + ": cannot be written");
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
