// The ground: fractal relief, craters and rocks, on posts of a world-wide lattice, bilinear between them.
// World frame: metres, x and y level, z up.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "fsw/vision/geometry/types.hpp"
#include "sim/world/landforms.hpp"
#include "sim/world/lattice_noise.hpp"
#include "sim/world/world_params.hpp"

namespace ilp::sim {

/// Posts of a rectangle, row-major from the smallest x and y; post (i, j) stands at ((first_i + i) * spacing_m,
/// (first_j + j) * spacing_m).
struct SurfacePatch {
  std::int32_t first_i = 0, first_j = 0;
  std::int32_t columns = 0, rows = 0;
  double spacing_m = 1;
  std::vector<float> height_m;
  std::vector<float> radiance;  ///< of the lit surface without its finest detail; level ground of mean albedo has 1

  [[nodiscard]] std::size_t index(std::int32_t i, std::int32_t j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(i);
  }
};

class Terrain {
 public:
  /// std::invalid_argument names the field that is out of its range.
  explicit Terrain(const WorldParams& params);

  [[nodiscard]] const WorldParams& params() const { return params_; }
  /// Every height lies between these, m.
  [[nodiscard]] double lowest() const { return -params_.relief_m; }
  [[nodiscard]] double highest() const { return params_.relief_m; }

  /// Height at a place, m. A few microseconds; for many places take a patch.
  [[nodiscard]] double height(double x, double y) const;
  /// Upward unit normal of the surface at a place, from slopes over two posts.
  [[nodiscard]] Vec3 normal(double x, double y) const;
  /// The posts that cover the rectangle. The same post has the same values in every patch.
  [[nodiscard]] SurfacePatch patch(const Rectangle& area) const;
  /// Relative brightness at a place due to detail finer than the posts resolve, for a pixel of `footprint_m` on the
  /// ground: octaves that the pixel cannot hold fade out. Mean 1.
  [[nodiscard]] double detail(double x, double y, double footprint_m) const {
    double sum = 0;
    for (const Octave& octave : detail_octaves_) {
      const double fade = octave.wavelength_m / footprint_m - 1;
      if (fade <= 0) break;
      const double noise = value_noise(x / octave.wavelength_m, y / octave.wavelength_m, octave.seed);
      sum += octave.amplitude * (fade < 1 ? fade : 1) * noise;
    }
    return 1 + sum;
  }

 private:
  struct Posts {
    std::int32_t first_i, first_j, columns, rows;
    std::vector<double> height;
    std::vector<double> albedo;
  };
  [[nodiscard]] Posts posts(std::int32_t first_i, std::int32_t first_j, std::int32_t columns, std::int32_t rows) const;
  void add_fractal(Posts& posts) const;
  void add_craters(Posts& posts) const;
  void add_rocks(Posts& posts) const;

  WorldParams params_;
  std::vector<Octave> height_octaves_;
  std::vector<Octave> albedo_octaves_;
  std::vector<Octave> detail_octaves_;
  Octave rockiness_;
  std::vector<SizeClass> craters_;
  std::vector<SizeClass> rocks_;
};

}  // namespace ilp::sim
