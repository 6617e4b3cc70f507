// Intersects rays with a patch of ground, exactly for the bilinear surface. A single ray traverses the lattice's
// squares (J. Amanatides, A. Woo, "A fast voxel traversal algorithm", Eurographics 1987) after it has skipped blocks
// below it. Neighbouring rays are first bounded as a bundle: minimum and maximum heights of blocks give an interval
// with all their hits, and slopes show whether a ray can hit the ground in it only once.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "fsw/vision/geometry/types.hpp"
#include "sim/world/terrain.hpp"

namespace ilp::world {

/// A ray in units of a patch's lattice: x and y in posts from the first post, z in metres. Its direction is downwards:
/// dz < 0.
struct LatticeRay {
  double x = 0, y = 0, z = 0;
  double dx = 0, dy = 0, dz = -1;
};

/// The interval of t in which the rays of a bundle hit the ground, at origin + t * direction.
struct HitInterval {
  double near = 0, far = 0;
  bool single = false;  ///< no ray of the bundle can hit the ground more than once in the interval
};

/// Bounds of heights and slopes of a part of the ground.
struct GroundBounds {
  float low, high;                     ///< of the heights, m
  float x_low, x_high, y_low, y_high;  ///< of the slopes, m per post
};

class RayCaster {
 public:
  /// Keeps a reference to the patch.
  explicit RayCaster(const SurfacePatch& patch);

  /// The smallest t at which origin + t * direction hits the ground. The origin must lie above the patch's highest
  /// post, and the direction must be downwards. Negative if the ray leaves the patch before a hit.
  [[nodiscard]] double hit(const Vec3& origin, const Vec3& direction) const;
  [[nodiscard]] double hit(const LatticeRay& ray) const { return hit_after((top_ - ray.z) / ray.dz, ray); }

  /// An interval for all rays in the convex hull of the outer rays: at every t, the points of these rays lie in the
  /// hull of the points of the outer rays. The rays must start above the patch and hit the ground inside it.
  [[nodiscard]] HitInterval narrow(std::span<const LatticeRay> outer) const;

  /// As hit(ray), for a ray of the bundle of `interval`. `guess` is an estimate of t; a wrong estimate only costs time.
  [[nodiscard]] double hit(const LatticeRay& ray, const HitInterval& interval, double guess) const;

 private:
  struct Level {
    std::int32_t columns, rows;
    std::vector<GroundBounds> blocks;
  };
  struct Squares {
    std::int32_t i0, j0, i1, j1;  // inclusive
  };
  [[nodiscard]] GroundBounds bounds_of_block(std::int32_t block_i, std::int32_t block_j) const;
  [[nodiscard]] GroundBounds bounds_of(const Squares& squares) const;
  [[nodiscard]] Squares squares_below(std::span<const LatticeRay> outer, double near, double far) const;
  [[nodiscard]] double hit_after(double t, const LatticeRay& ray) const;
  [[nodiscard]] double hit_in_block(const LatticeRay& ray, const std::array<double, 2>& per_direction,
                                    std::int32_t block_i, std::int32_t block_j, double t0, double t1) const;
  [[nodiscard]] double hit_in_square(const LatticeRay& ray, std::int32_t i, std::int32_t j, double t0, double t1) const;

  static constexpr std::int32_t block_shift = 2;
  static constexpr std::int32_t block_side = 1 << block_shift;  // squares
  const SurfacePatch& patch_;
  std::vector<Level> levels_;  // each with blocks twice as wide as the previous level
  double low_ = 0, top_ = 0;
};

}  // namespace ilp::world
