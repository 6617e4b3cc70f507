// Pieces of a keyframe's image about its corners, kept when the image itself is gone. When a later keyframe
// shows the same ground, they are registered to its image, so that a link knows to a small part of a pixel where both
// see the same point; features alone are known to a pixel or more.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <type_traits>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/result.hpp"
#include "fsw/vision/features/feature_types.hpp"
#include "fsw/vision/features/subpixel.hpp"

namespace ilp {

inline constexpr std::int32_t place_patch_side = 13;  ///< px that are registered
/// Kept: one pixel more on each side for gradients, one for smoothing, and one for a position between pixels.
inline constexpr std::int32_t kept_patch_side = place_patch_side + 5;

/// Without gaps, because a record holds the bytes as they are. Grey values have 16 steps between the darkest and the
/// brightest one, which adds less to them than the camera's noise where there is texture.
struct PlacePatch {
  float x = 0, y = 0;       ///< its place, px
  float inverse_depth = 0;  ///< of the ground there, 1 / strip unit; 0: unknown
  std::uint8_t darkest = 0, brightest = 0;
  std::array<std::uint8_t, static_cast<std::size_t>(kept_patch_side) * kept_patch_side / 2>
      steps{};  ///< two pixels in a byte, the first in the low half, row by row
};
static_assert(sizeof(PlacePatch) == 176 && std::is_trivially_copyable_v<PlacePatch>);
using PlacePatches = FixedVector<PlacePatch, limits::max_place_patches>;

/// Where the ground of a patch is seen in another image.
struct PatchSighting {
  std::uint16_t patch = 0;
  float x = 0, y = 0;  ///< px
  float score = 0;     ///< normalised cross correlation after registration
};
using PatchSightings = FixedVector<PatchSighting, limits::max_place_patches>;

struct PatchSearchParams {
  std::int32_t radius_px = 8;  ///< about the prediction, in pixels of the patch: relief and tilt
  float min_score = 0.7F;
};
inline constexpr std::int32_t max_patch_search_px = 12;

struct HarrisWorkspace;  // fsw/vision/features/harris_workspace.hpp

struct PlacePatchWorkspace {
  static constexpr std::int32_t window_side = 96;
  std::array<std::uint16_t, static_cast<std::size_t>(window_side) * window_side> window;
  std::array<std::array<std::uint16_t, window_side>, 3> row_sums;  ///< of three rows, the latest ones
  std::array<std::uint16_t, static_cast<std::size_t>(kept_patch_side) * kept_patch_side> smoothed;
  static constexpr std::int32_t area_side = place_patch_side + 2 * max_patch_search_px;
  static constexpr std::int32_t area_stride = 48;
  std::array<std::int32_t, static_cast<std::size_t>(area_side) * area_side> sampled;
  std::array<std::int16_t, static_cast<std::size_t>(area_side) * area_stride> area;  ///< rows of area_stride
  std::array<std::uint8_t, static_cast<std::size_t>(kept_patch_side) * kept_patch_side> grey;
  PatchTemplate prepared;
  Corners corners;
  bool corners_found;
};

/// Patches about corners spread evenly over the image whose texture determines where they are. Their depths are left
/// unknown. One call of begin_place_patches, then of place_patches_slice with the same arguments while there is more:
/// a slice finds some of the corners; the last one cuts out the patches. The Status of detect_corners().
Status begin_place_patches(GrayView image, HarrisWorkspace& harris, PlacePatchWorkspace& workspace,
                           PlacePatches& patches);
Result<bool> place_patches_slice(GrayView image, HarrisWorkspace& harris, PlacePatchWorkspace& workspace,
                                 PlacePatches& patches);

/// Seeks each patch about the place that the homography (row-major, px of the patches' image to px of `image`)
/// predicts inside the image, at its rotation and scale: first at whole pixels by normalised cross correlation, then by
/// registration with an affine warp. Where the image is finer than the patch, it is smoothed until both are equally
/// sharp. Patches beyond the border, and those that are not found, have no sighting. Of more than
/// limits::max_link_points in view every n-th is sought.
/// `invalid_argument` (radius, homography).
Status find_place_patches(std::span<const PlacePatch> patches, GrayView image,
                          const double (&plane_image_from_patches)[9], const PatchSearchParams& params,
                          PlacePatchWorkspace& workspace, PatchSightings& sightings);

}  // namespace ilp
