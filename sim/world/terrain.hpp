// The lit ground of a simulated world: fractal relief, craters, rocks, dunes, channels and layers, or a user's maps.
// Heights and light are computed at posts, the points of a world-wide lattice, with bilinear interpolation. World
// frame: metres, x and y level, z up.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "fsw/vision/geometry/types.hpp"
#include "sim/world/landforms.hpp"
#include "sim/world/lattice_noise.hpp"
#include "sim/world/terrain_posts.hpp"
#include "sim/world/world_params.hpp"

namespace ilp::world {

/// The posts of a rectangle, row-major from the smallest x and y. Post (i, j) is at ((first_i + i) * spacing_m,
/// (first_j + j) * spacing_m).
struct SurfacePatch {
  std::int32_t first_i = 0, first_j = 0;
  std::int32_t columns = 0, rows = 0;
  double spacing_m = 1;
  std::vector<float> height_m;
  std::vector<float> radiance;  ///< of the lit surface without `detail`; level ground of mean albedo has 1

  [[nodiscard]] std::size_t index(std::int32_t i, std::int32_t j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(i);
  }
};

/// Thread-safe. Recently used tiles of ground are cached (about 100 MiB at most), so that overlapping frames cost
/// little.
class Terrain {
 public:
  /// Throws std::invalid_argument that names a field that is out of range, and std::runtime_error that names a file
  /// that cannot be used.
  explicit Terrain(const WorldParams& params);
  ~Terrain();
  Terrain(Terrain&&) noexcept;
  Terrain& operator=(Terrain&&) noexcept;

  [[nodiscard]] const WorldParams& params() const { return ground_.world(); }
  /// Bounds of all heights, m.
  [[nodiscard]] double lowest() const { return ground_.lowest(); }
  [[nodiscard]] double highest() const { return ground_.highest(); }

  /// Height at a point, m. Takes a few microseconds; use a patch for many points.
  [[nodiscard]] double height(double x, double y) const;
  /// Upward unit normal of the surface at a point, from slopes over two post spacings.
  [[nodiscard]] Vec3 normal(double x, double y) const;
  /// The posts that cover the rectangle. A post has the same values in every patch. Throws std::runtime_error for a
  /// rectangle of more than 2^26 posts, or beyond 2^30 posts from the origin.
  [[nodiscard]] SurfacePatch patch(const Rectangle& area) const;
  /// The features that touch the rectangle (Ground::features).
  [[nodiscard]] std::vector<PlantedFeature> features(const Rectangle& area) const { return ground_.features(area); }
  /// Factor on the brightness at a point by detail that is finer than the posts, mean 1. Octaves that a pixel of
  /// `footprint_m` on the ground cannot resolve fade out.
  [[nodiscard]] double detail(double x, double y, double footprint_m) const {
    double sum = 0;
    for (const Octave& octave : ground_.detail_octaves()) {
      const double fade = octave.wavelength_m / footprint_m - 1;
      if (fade <= 0) break;
      const double noise = value_noise(x / octave.wavelength_m, y / octave.wavelength_m, octave.seed);
      sum += octave.amplitude * (fade < 1 ? fade : 1) * noise;
    }
    return 1 + sum;
  }
  /// The same for a point at height z, where liquid has no detail (1).
  [[nodiscard]] double detail(double x, double y, double z, double footprint_m) const {
    return has_liquid_ && z <= liquid_top_ ? 1 : detail(x, y, footprint_m);
  }

 private:
  struct Tiles;

  Ground ground_;
  bool has_liquid_ = false;
  double liquid_top_ = 0;
  std::unique_ptr<Tiles> tiles_;
};

}  // namespace ilp::world
