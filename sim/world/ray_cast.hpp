// Rays against a patch of ground, exact for the bilinear surface: a walk over the lattice's squares (J. Amanatides,
// A. Woo, "A fast voxel traversal algorithm", Eurographics 1987), first in blocks that the ray may pass above.
#pragma once

#include <cstdint>
#include <vector>

#include "fsw/vision/geometry/types.hpp"
#include "sim/world/terrain.hpp"

namespace ilp::sim {

class RayCaster {
 public:
  /// Borrows the patch.
  explicit RayCaster(const SurfacePatch& patch);

  /// The smallest t at which origin + t * direction meets the ground; the origin lies above the patch's highest post,
  /// the direction goes down. Negative when the ray leaves the patch first.
  [[nodiscard]] double hit(const Vec3& origin, const Vec3& direction) const;

 private:
  struct Ray;  // in units of the lattice
  [[nodiscard]] double hit_in_block(const Ray& ray, std::int32_t block_i, std::int32_t block_j, double t0,
                                    double t1) const;
  [[nodiscard]] double hit_in_square(const Ray& ray, std::int32_t i, std::int32_t j, double t0, double t1) const;

  static constexpr std::int32_t block_side = 4;  // squares
  const SurfacePatch& patch_;
  std::int32_t block_columns_ = 0, block_rows_ = 0;
  std::vector<float> block_top_;
  double top_ = 0;
};

}  // namespace ilp::sim
