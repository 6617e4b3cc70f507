// Harris corners (C. Harris, M. Stephens, "A combined corner and edge detector", 1988), spread evenly over the image.
#pragma once

#include "cfg/limits.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/features/feature_types.hpp"

namespace ilp {

struct HarrisParams {
  std::int32_t target_count = 1000;   ///< corners asked for; at most limits::max_corners
  std::int32_t min_distance_px = 6;   ///< between two corners
  std::int32_t border_px = 12;        ///< no corner nearer to the border, so that its patch is inside
  float kappa = 0.04F;                ///< Harris' constant
  float relative_threshold = 1e-4F;   ///< of the strongest response; weaker maxima are noise
};

struct HarrisWorkspace;  // defined in harris_workspace.hpp: a component owns one
/// Positions are refined to sub-pixel by a quadratic fit of the response. An image without texture gives no corners and ok.
Status detect_corners(GrayView image, const HarrisParams& params, HarrisWorkspace& workspace, Corners& corners);

}  // namespace ilp
