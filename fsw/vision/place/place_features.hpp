// Features by which ground is recognised at any rotation and from another height: oriented corners with binary
// descriptors (E. Rublee et al., "ORB: an efficient alternative to SIFT or SURF", ICCV 2011).
#pragma once

#include <type_traits>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/result.hpp"

namespace ilp {

/// Without gaps, because a record holds the bytes as they are.
struct PlaceFeature {
  float x = 0, y = 0;  ///< px of the full image, pixel centres at integers
  std::uint8_t level =
      0;  ///< of the scales in which it was found; level k is place_level_scale(k) as large as the image
  std::uint8_t angle = 0;  ///< of its texture, 256 for a full turn, from x towards y
  std::uint8_t reserved[2] = {};
  std::uint32_t descriptor[8] = {};  ///< 256 comparisons of grey values, relative to the angle
};
static_assert(sizeof(PlaceFeature) == 44 && std::is_trivially_copyable_v<PlaceFeature>);

using PlaceFeatures = FixedVector<PlaceFeature, limits::max_place_features>;

inline constexpr int place_levels = 5;
/// Level 0 is 0.75 of the image; each level is 1 / 1.26 of the one before.
inline constexpr double place_level_ratio = 1.26;

struct HarrisWorkspace;        // fsw/vision/features/harris_workspace.hpp
struct PlaceFeatureWorkspace;  // place_feature_workspace.hpp

/// At most `wanted` corners of all levels, and limits::max_place_features, spread evenly over the image. The same image
/// gives the same bytes on every machine. An image without texture gives no features and ok. `image_too_large`.
Status find_place_features(GrayView image, std::size_t wanted, HarrisWorkspace& harris,
                           PlaceFeatureWorkspace& workspace, PlaceFeatures& features);

/// The same in slices: one call of begin_place_features, then of place_features_slice with the same arguments while
/// there is more. A slice reduces a level, finds some of its corners, or describes them.
Status begin_place_features(GrayView image, PlaceFeatureWorkspace& workspace, PlaceFeatures& features);
Result<bool> place_features_slice(GrayView image, std::size_t wanted, HarrisWorkspace& harris,
                                  PlaceFeatureWorkspace& workspace, PlaceFeatures& features);

}  // namespace ilp
