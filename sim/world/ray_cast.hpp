// Rays against a patch of ground, exact for the bilinear surface. A single ray walks over the lattice's squares
// (J. Amanatides, A. Woo, "A fast voxel traversal algorithm", Eurographics 1987), first in blocks that it may pass
// above. Neighbouring rays share what a bundle of them knows: an interval that holds all their hits, found with the
// blocks' least and greatest heights, and whether the ground in it is too gentle to be met twice.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "fsw/vision/geometry/types.hpp"
#include "sim/world/terrain.hpp"

namespace ilp::world {

/// A ray in units of a patch's lattice: x and y in posts from its first post, z in metres. It goes down: dz < 0.
struct LatticeRay {
  double x = 0, y = 0, z = 0;
  double dx = 0, dy = 0, dz = -1;
};

/// Where the rays of a bundle meet the ground.
struct HitInterval {
  double near = 0, far = 0;  ///< of the parameter t
  bool single = false;       ///< inside it, no ray of the bundle can meet the ground more than once
};

/// Bounds of a part of the ground.
struct GroundBounds {
  float low, high;                     ///< of the heights, m
  float x_low, x_high, y_low, y_high;  ///< of the slopes, m per post
};

class RayCaster {
 public:
  /// Borrows the patch.
  explicit RayCaster(const SurfacePatch& patch);

  /// The smallest t at which origin + t * direction meets the ground; the origin lies above the patch's highest post,
  /// the direction goes down. Negative when the ray leaves the patch first.
  [[nodiscard]] double hit(const Vec3& origin, const Vec3& direction) const;
  [[nodiscard]] double hit(const LatticeRay& ray) const { return hit_after((top_ - ray.z) / ray.dz, ray); }

  /// For all rays in the convex hull of the outer ones: at every t, their places lie in the hull of the outer rays'
  /// places. The rays start above the patch and meet it inside.
  [[nodiscard]] HitInterval narrow(std::span<const LatticeRay> outer) const;

  /// The same as `hit`, for a ray of the bundle that `interval` belongs to. `guess` is a t near the hit; a wrong guess
  /// only costs time.
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
