// The overlap of two images by oriented features. It serves where the views are turned, tilted or far apart, so that
// neither a window nor the corners of one image look the same in the other one.
#pragma once

#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/overlap/overlap.hpp"
#include "fsw/vision/place/place_features.hpp"
#include "fsw/vision/place/place_verification.hpp"

namespace ilp {

struct HarrisWorkspace;  // fsw/vision/features/harris_workspace.hpp
struct PlaceScratch;     // place_scratch.hpp

/// The verdict is ok, with overlap, `b_from_a` and the plane's homography, if verify_place takes both for the same
/// ground; otherwise overlap_unknown. The fields of the correlation stay 0. Both images have the same size. They are
/// compared by limits::place_features, and if that is not enough by `most_features`, where these are more.
/// `image_size_changed`, `image_too_large`.
Status measure_overlap_by_places(GrayView image_a, GrayView image_b, std::size_t most_features, PlaceScratch& scratch,
                                 OverlapResult& result);

}  // namespace ilp
