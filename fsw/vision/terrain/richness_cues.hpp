// The two halves of the richness cues; see richness.hpp for the formulas.
#pragma once

#include "fsw/vision/terrain/richness.hpp"

namespace ilp {

inline constexpr std::int32_t cell = richness_cell_px;

/// The value at rank floor(share count) of `values`, which are reordered; 0 if there are none.
[[nodiscard]] double quantile(float* values, std::size_t count, double share);

/// The parts in which the cues are measured, in this order. Each needs those before it.
inline constexpr std::int32_t image_cue_parts = 2, terrain_cue_parts = 3;

/// gradient_fine, gradient_coarse, entropy, contrast.
void measure_image_cues(std::int32_t part, GrayView image, MaskView mask, double noise_grey,
                        RichnessWorkspace& workspace, RichnessCues& cues);

/// relief to curvature, and has_terrain.
void measure_terrain_cues(std::int32_t part, const CameraModel& camera, ImageView<const float> inverse_depth,
                          ImageView<const float> sigma, MaskView mask, RichnessWorkspace& workspace,
                          RichnessCues& cues);

}  // namespace ilp
