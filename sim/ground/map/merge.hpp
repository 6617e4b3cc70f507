// Makes surface patches in the strip's world from the masked depth maps of keyframes.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/map/pixel_rays.hpp"

namespace ilp::map {

struct SurfaceVertex {
  float x = 0, y = 0, z = 0;  ///< strip's world, strip units
  std::uint8_t grey = 128;    ///< 128 if the keyframe has no image
  float sigma = 0;            ///< standard deviation of z from the error of the depth; 0: unknown
};

/// In a grid of vertex indices: no vertex.
inline constexpr std::uint32_t no_vertex = 0xFFFFFFFFU;

struct SurfaceMesh {
  std::vector<SurfaceVertex> vertices;
  std::vector<std::array<std::uint32_t, 3>> faces;  ///< counter-clockwise seen from the camera
};

struct MergeParams {
  /// Largest difference of depth between neighbouring pixels of one surface, divided by their distance on the ground. 4
  /// is a wall of 76 degrees seen from above; a matching error of half a pixel at 80 % overlap causes 2.5.
  double max_depth_jump = 4;
};

/// Whether the keyframe has a final pose, a focal length, and a depth map of its camera's size.
[[nodiscard]] bool has_surface(const intake::Keyframe& keyframe);
/// The surface of one keyframe from its decoded rasters; empty if the depth map does not have the camera's size. Masks
/// are disjoint by construction (decisions.md, 9), so that patches of different keyframes do not overlap.
[[nodiscard]] SurfaceMesh keyframe_surface(const intake::Keyframe& keyframe, const intake::KeyframeRasters& rasters,
                                           const MergeParams& params, PixelRays& rays);

/// Widest hole that laid_surface fills, along a row or column of the image.
inline constexpr std::int32_t most_laid_px = 96;
/// The surface in the holes of the keyframe's depth map, for pictures only. A pixel is filled if measured pixels lie on
/// both sides of it in its row and in its column, with at most most_laid_px pixels between the two. Its inverse depth
/// is interpolated linearly, which is exact on a plane. Nothing is extrapolated. Faces extend to the measured pixels
/// about each hole; errors are unknown. The image is sharp in small holes only, because the codec favours the mask.
[[nodiscard]] SurfaceMesh laid_surface(const intake::Keyframe& keyframe, const intake::KeyframeRasters& rasters,
                                       PixelRays& rays);

}  // namespace ilp::map
