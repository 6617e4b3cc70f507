// Harris corners (C. Harris, M. Stephens, "A combined corner and edge detector", 1988), spread evenly over the image.
#pragma once

#include "cfg/limits.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/result.hpp"
#include "fsw/vision/features/feature_types.hpp"

namespace ilp {

struct HarrisParams {
  std::int32_t target_count = 1000;  ///< requested corners; at most limits::max_corners
  std::int32_t min_distance_px = 5;  ///< between two corners, in x or in y; 2 to 64
  std::int32_t border_px = 12;       ///< no corner nearer to the border, so that its patch is inside
};

struct HarrisWorkspace;  // defined in harris_workspace.hpp: a component owns one
/// Positions are refined to sub-pixel by a quadratic fit of the response. The image is divided into buckets of about
/// eight corners each; every bucket gives its strongest corners, and the others make up for buckets with fewer.
/// An image without texture gives no corners and ok. Corners come bucket by bucket, strongest first. `invalid_argument`
/// (target count, distance), `image_too_large`.
Status detect_corners(GrayView image, const HarrisParams& params, HarrisWorkspace& workspace, Corners& corners);

/// The same in slices: one call of begin_corners, then of detect_corners_slice with the same arguments while there
/// is more. A slice computes the response of a band of rows; the last one chooses the corners.
Status begin_corners(GrayView image, const HarrisParams& params, HarrisWorkspace& workspace, Corners& corners);
Result<bool> detect_corners_slice(GrayView image, const HarrisParams& params, HarrisWorkspace& workspace,
                                  Corners& corners);

}  // namespace ilp
