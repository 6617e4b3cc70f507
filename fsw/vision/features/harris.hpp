// Harris corners (C. Harris, M. Stephens, "A combined corner and edge detector", 1988), spread evenly over the image.
#pragma once

#include "cfg/limits.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/result.hpp"
#include "fsw/vision/features/feature_types.hpp"

namespace ilp {

struct HarrisParams {
  std::int32_t target_count = 1000;  ///< requested corners; at most limits::max_corners
  std::int32_t min_distance_px = 5;  ///< minimum distance of two corners in x or in y; 2 to 64
  std::int32_t border_px = 12;  ///< corners keep this distance from the image border, so that their patches lie inside
};

struct HarrisWorkspace;  // defined in harris_workspace.hpp: a component owns one
/// Detects corners. The image is divided into buckets of about eight corners each. Every bucket contributes its
/// strongest corners; if a bucket has fewer, other buckets contribute more. Positions are refined to sub-pixel by a
/// quadratic fit of the response. Corners are ordered bucket by bucket, strongest first. An image without texture gives
/// no corners and ok. Returns `invalid_argument` if the target count or the distance is out of range, `image_too_large`
/// if the image exceeds the limits.
Status detect_corners(GrayView image, const HarrisParams& params, HarrisWorkspace& workspace, Corners& corners);

/// Detects corners in slices: call begin_corners once, then detect_corners_slice with the same arguments until it
/// returns false. A slice computes the response of a band of rows; the last slice selects the corners.
Status begin_corners(GrayView image, const HarrisParams& params, HarrisWorkspace& workspace, Corners& corners);
Result<bool> detect_corners_slice(GrayView image, const HarrisParams& params, HarrisWorkspace& workspace,
                                  Corners& corners);

}  // namespace ilp
