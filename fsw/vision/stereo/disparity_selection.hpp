// From the aggregated costs of a row to sub-pixel disparities, each with its error or rejected.
#pragma once

#include <array>
#include <cstdint>

#include "fsw/vision/stereo/ncc_cost.hpp"
#include "fsw/vision/stereo/path_aggregation.hpp"

namespace ilp {

struct SelectionWorkspace {
  std::array<std::int16_t, static_cast<std::size_t>(limits::max_rectified_width) + max_padded_disparities> right_best;
  std::array<std::int16_t, static_cast<std::size_t>(limits::max_rectified_width)> best_index;
  std::array<std::uint8_t, static_cast<std::size_t>(limits::max_rectified_width)> unique;
};

/// Winner takes all, then: uniqueness (of the aggregated cost), left-right check (a right pixel's best aggregated cost
/// must be this one or that of a neighbouring disparity), texture, mean correlation of the fit's support, and a
/// quadratic fit around the winner. `sigma_px` 0 = invalid. The error is that of least-squares matching of the window:
/// with N = V + n s^2 (ncc_cost.hpp) the curvature of the correlation times N is the gradient energy, and the residual
/// is what the correlation lacks beyond the damping,
///   sigma^2 = 2 (N (1 - ncc) - n s^2) / (n N |ncc''|)  +  sigma_floor^2.
/// `sums` is overwritten beyond `count` disparities.
void select_row(const NccRows& rows, std::int32_t count, const StereoParams& params, const std::int16_t* ncc,
                std::int16_t* sums, const float* variance, SelectionWorkspace& workspace, float* disparity_px,
                float* sigma_px);

}  // namespace ilp
