// The masked depth of a keyframe as a piece of surface in the strip's world.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/map/pixel_rays.hpp"

namespace ilp::map {

struct SurfaceVertex {
  float x = 0, y = 0, z = 0;
  std::uint8_t grey = 128;
  float sigma = 0;  ///< one sigma of z, from the error of its depth; 0: unknown
};

/// Marks a place without a vertex in a grid of indices of vertices.
inline constexpr std::uint32_t no_vertex = 0xFFFFFFFFU;

struct SurfaceMesh {
  std::vector<SurfaceVertex> vertices;
  std::vector<std::array<std::uint32_t, 3>> faces;  ///< counter-clockwise seen from the camera
};

struct MergeParams {
  /// Neighbours whose depths differ by more than this many times their distance on the ground are two surfaces: 4 is a
  /// wall of 76 degrees seen from above, while a matching error of half a pixel at 80 % overlap is 2.5.
  double max_depth_jump = 4;
};

[[nodiscard]] bool has_surface(const intake::Keyframe& keyframe);
/// The surface of one keyframe from its decoded rasters. Masks are disjoint by construction (decisions.md, 9): pieces
/// lie side by side.
[[nodiscard]] SurfaceMesh keyframe_surface(const intake::Keyframe& keyframe, const intake::KeyframeRasters& rasters,
                                           const MergeParams& params, PixelRays& rays);

/// Holes are laid no wider than this along a row or column of the image.
inline constexpr std::int32_t most_laid_px = 96;
/// What the keyframe's image shows where no depth was measured, for pictures: between measured pixels of both
/// row and column, at most most_laid_px apart, the inverse depth is interpolated, which is exact on a plane. Nothing is
/// extrapolated. The faces reach to the measured pixels about each hole; errors are not known. The image is sharp in
/// small holes only, because it was coded for the mask.
[[nodiscard]] SurfaceMesh laid_surface(const intake::Keyframe& keyframe, const intake::KeyframeRasters& rasters,
                                       PixelRays& rays);

}  // namespace ilp::map
