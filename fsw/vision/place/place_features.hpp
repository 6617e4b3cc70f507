// Finds features that recognise ground at any rotation and from another height: oriented corners with binary
// descriptors (E. Rublee et al., "ORB: an efficient alternative to SIFT or SURF", ICCV 2011).
#pragma once

#include <type_traits>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/result.hpp"

namespace ilp {

/// A feature. Without padding, because a record stores its bytes.
struct PlaceFeature {
  float x = 0, y = 0;  ///< px of the full image, pixel centres at integers
  std::uint8_t level =
      0;  ///< pyramid level in which it was found; the scale of level k to the image is 0.75 / place_level_ratio^k
  std::uint8_t angle = 0;  ///< orientation of its texture, from x towards y; 256 is a full turn
  std::uint8_t reserved[2] = {};
  std::uint32_t descriptor[8] = {};  ///< 256 comparisons of grey values, relative to the angle
};
static_assert(sizeof(PlaceFeature) == 44 && std::is_trivially_copyable_v<PlaceFeature>);

using PlaceFeatures = FixedVector<PlaceFeature, limits::max_place_features>;

inline constexpr int place_levels = 5;
/// Level 0 has 0.75 times the image's width; each further level is smaller by this ratio.
inline constexpr double place_level_ratio = 1.26;

struct HarrisWorkspace;        // fsw/vision/features/harris_workspace.hpp
struct PlaceFeatureWorkspace;  // place_feature_workspace.hpp

/// Finds at most `wanted` (and limits::max_place_features) features on all levels, spread evenly over the image. The
/// same image gives the same bytes on every machine. An image without texture gives no features and is no error.
/// Returns `image_too_large` if the image is above the limits.
Status find_place_features(GrayView image, std::size_t wanted, HarrisWorkspace& harris,
                           PlaceFeatureWorkspace& workspace, PlaceFeatures& features);

/// find_place_features in slices: call begin_place_features once, then place_features_slice with the same arguments
/// while it returns true. A slice reduces a level, finds some of its corners, or describes them.
Status begin_place_features(GrayView image, PlaceFeatureWorkspace& workspace, PlaceFeatures& features);
Result<bool> place_features_slice(GrayView image, std::size_t wanted, HarrisWorkspace& harris,
                                  PlaceFeatureWorkspace& workspace, PlaceFeatures& features);

}  // namespace ilp
