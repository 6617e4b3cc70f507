// Measures the image cues and the terrain cues of richness.hpp, which has their formulas.
#pragma once

#include "fsw/vision/terrain/richness.hpp"

namespace ilp {

inline constexpr std::int32_t cell = richness_cell_px;

/// Returns the value at rank floor(share * count) of `values`, which it reorders; 0 if count is 0.
[[nodiscard]] double quantile(float* values, std::size_t count, double share);

/// Numbers of the parts in which the cues are measured, in order. Each part needs those before it.
inline constexpr std::int32_t image_cue_parts = 2, terrain_cue_parts = 3;

/// Measures part `part` of gradient_fine, gradient_coarse, entropy and contrast.
void measure_image_cues(std::int32_t part, GrayView image, MaskView mask, double noise_grey,
                        RichnessWorkspace& workspace, RichnessCues& cues);

/// Measures part `part` of the cues from relief to curvature, and has_terrain.
void measure_terrain_cues(std::int32_t part, const CameraModel& camera, ImageView<const float> inverse_depth,
                          ImageView<const float> sigma, MaskView mask, RichnessWorkspace& workspace,
                          RichnessCues& cues);

}  // namespace ilp
