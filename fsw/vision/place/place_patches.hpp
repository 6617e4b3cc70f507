// Patches of a keyframe's image around its corners, kept after the image is deleted. When a later keyframe shows the
// same ground, they are registered to its image. This gives correspondences to a small part of a pixel; those of
// features have errors of a pixel or more.
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

inline constexpr std::int32_t place_patch_side = 13;  ///< px; the part that is registered
/// Side of the patch that is kept, px: margins for gradients, for smoothing, and for a position between pixels.
inline constexpr std::int32_t kept_patch_side = place_patch_side + 5;

/// A patch. Without padding, because a record stores its bytes. Grey values are quantised to 16 steps from the darkest
/// to the brightest; in textured patches this adds less noise than the camera.
struct PlacePatch {
  float x = 0, y = 0;       ///< its position in the keyframe, px
  float inverse_depth = 0;  ///< of the ground there, 1 / strip unit; 0: unknown
  std::uint8_t darkest = 0, brightest = 0;
  std::array<std::uint8_t, static_cast<std::size_t>(kept_patch_side) * kept_patch_side / 2>
      steps{};  ///< two pixels in a byte, the first in the low half, row by row
};
static_assert(sizeof(PlacePatch) == 176 && std::is_trivially_copyable_v<PlacePatch>);
using PlacePatches = FixedVector<PlacePatch, limits::max_place_patches>;

/// Position at which another image shows the ground of a patch.
struct PatchSighting {
  std::uint16_t patch = 0;
  float x = 0, y = 0;  ///< px
  float score = 0;     ///< normalised cross correlation after registration
};
using PatchSightings = FixedVector<PatchSighting, limits::max_place_patches>;

struct PatchSearchParams {
  std::int32_t radius_px = 8;  ///< largest shift from the prediction, px of the patch; relief and tilt cause it
  float min_score = 0.7F;
};
inline constexpr std::int32_t max_patch_search_px = 12;

struct HarrisWorkspace;  // fsw/vision/features/harris_workspace.hpp

struct PlacePatchWorkspace {
  static constexpr std::int32_t window_side = 96;
  std::array<std::uint16_t, static_cast<std::size_t>(window_side) * window_side> window;
  std::array<std::array<std::uint16_t, window_side>, 3> row_sums;  ///< sums of the latest three rows
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

/// Cuts out patches around corners, spread evenly over the image, whose texture determines their position. Their depths
/// are unknown. Call begin_place_patches once, then place_patches_slice with the same arguments while it returns true:
/// slices find the corners, and the last one cuts out the patches. Returns the errors of detect_corners().
Status begin_place_patches(GrayView image, HarrisWorkspace& harris, PlacePatchWorkspace& workspace,
                           PlacePatches& patches);
Result<bool> place_patches_slice(GrayView image, HarrisWorkspace& harris, PlacePatchWorkspace& workspace,
                                 PlacePatches& patches);

/// Searches for each patch in `image` around its prediction by the homography (row-major, px of the patches' image to
/// px of `image`), at the predicted rotation and scale: first at integer shifts by normalised cross-correlation, then
/// by registration with an affine warp. If the image has a higher resolution than the patch, it is smoothed until both
/// are equally sharp. Patches beyond the border or not found have no sighting. If more than limits::max_link_points
/// patches are in view, every n-th is searched for. Returns `invalid_argument` if the radius or the homography is out
/// of range.
Status find_place_patches(std::span<const PlacePatch> patches, GrayView image,
                          const double (&plane_image_from_patches)[9], const PatchSearchParams& params,
                          PlacePatchWorkspace& workspace, PatchSightings& sightings);

}  // namespace ilp
