// Measures the overlap of two images from oriented features. It is for views that are rotated, tilted or far apart, so
// that neither correlation nor the matching of corners succeeds.
#pragma once

#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/overlap/overlap.hpp"
#include "fsw/vision/place/place_features.hpp"
#include "fsw/vision/place/place_verification.hpp"

namespace ilp {

struct HarrisWorkspace;  // fsw/vision/features/harris_workspace.hpp
struct PlaceScratch;     // place_scratch.hpp

/// If verify_place decides that both images show the same ground, the verdict is `ok`, and overlap, `b_from_a`, the
/// plane's homography and `sigma_px` are set. Otherwise the verdict is `overlap_unknown`. The fields of the correlation
/// stay 0. The images are compared with limits::place_features features each. If that fails, they are compared with
/// `most_features`, if this is larger. Returns `image_size_changed` if the sizes differ, `image_too_large` if the
/// images are above the limits.
Status measure_overlap_by_places(GrayView image_a, GrayView image_b, std::size_t most_features, PlaceScratch& scratch,
                                 OverlapResult& result);

}  // namespace ilp
