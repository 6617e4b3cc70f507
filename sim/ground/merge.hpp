// The masked depths of a strip merged into one surface in the strip's world.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/ground/flight_model.hpp"
#include "sim/ground/pixel_rays.hpp"

namespace ilp::ground {

struct SurfaceVertex {
  float x = 0, y = 0, z = 0;
  std::uint8_t grey = 128;
  float sigma = 0;  ///< one sigma of z, from the error of its depth; 0: not told
};

/// Masks are disjoint by construction (decisions.md, 9), so the pieces lie side by side and need no blending.
struct SurfaceMesh {
  std::vector<SurfaceVertex> vertices;
  std::vector<std::array<std::uint32_t, 3>> faces;  ///< counter-clockwise seen from the camera
};

struct MergeParams {
  std::int32_t stride = 1;  ///< every n-th pixel of every n-th row
  /// Neighbours whose depths differ by more than this many times their distance on the ground are two surfaces: 4 is a
  /// wall of 76 degrees seen from above, while a matching error of half a pixel at 80 % overlap is 2.5.
  double max_depth_jump = 4;
};

[[nodiscard]] bool has_surface(const Keyframe& keyframe);
/// One keyframe's piece.
[[nodiscard]] SurfaceMesh keyframe_surface(const Keyframe& keyframe, const MergeParams& params, PixelRays& rays);
[[nodiscard]] SurfaceMesh merge_strip(const Flight& flight, const Strip& strip, const MergeParams& params,
                                      PixelRays& rays);
/// The smallest stride with at most `max_vertices` vertices.
[[nodiscard]] std::int32_t stride_for(const Flight& flight, const Strip& strip, std::size_t max_vertices);

}  // namespace ilp::ground
