// Sunlight on posts: how squarely it falls, and what stands in its way.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "fsw/vision/geometry/types.hpp"

namespace ilp::sim {

/// The way from a post towards the sun, sampled where it crosses the lattice's lines.
class SunPath {
 public:
  static constexpr std::int32_t length = 32;  ///< posts; shadows are followed as far as this

  SunPath(double azimuth_rad, double elevation_rad, double spacing_m);

  /// Cosine of the light's incidence over that on level ground; 0 when the slope faces away.
  [[nodiscard]] double facing(double slope_x, double slope_y) const;

  /// For `count` posts of a row: the height below which a post is in the shadow of another. `row` is the first of them
  /// in a grid of `stride` columns, which has at least `length` posts more on every side.
  void shading_heights(const double* row, std::int32_t stride, std::int32_t count, std::vector<double>& out) const;

 private:
  Vec3 sun_;
  bool along_x_;            // the lattice's lines are crossed along x, else along y
  std::int32_t direction_;  // +1 or -1, along that axis
  double drift_;            // posts along the other axis per step
  double rise_m_;           // of the ray per step
};

}  // namespace ilp::sim
