// Sub-pixel position of a correlation peak between whole disparities, and its error.
#pragma once

#include <algorithm>
#include <cmath>

namespace ilp {

/// Correlations at the winning disparity and at the disparities one below (`before`) and one above (`after`).
/// peak_vertex takes any common unit; for peak_sigma a perfect correlation is 1.
struct CorrelationPeak {
  float before = 0, at = 0, after = 0;
};

/// Returns the vertex of the parabola through the three correlations, px from the winning disparity, -0.5 to 0.5.
[[nodiscard]] inline float peak_vertex(const CorrelationPeak& peak) {
  const float curvature = 2 * peak.at - peak.before - peak.after;
  const float vertex = 0.5F * (peak.after - peak.before) / curvature;
  // Selections without branches, so that the compiler vectorises whole rows of peaks.
  const float clamped = std::min(std::max(vertex, -0.5F), 0.5F);
  return curvature > 0 ? clamped : 0.0F;
}

/// Returns the one-sigma error of the peak, px, as in least-squares matching of the window. With N = V + n s^2
/// (ncc_cost.hpp), the curvature of the correlation times N is the gradient energy, and the residual is the part of the
/// correlation's deficit that exceeds the damping,
///   sigma^2 = 2 (N (1 - ncc) - n s^2) / (n N |ncc''|).
/// `deviation` is V, `damping` is n s^2, `area` is n.
[[nodiscard]] inline float peak_sigma(const CorrelationPeak& peak, float deviation, float damping, float area) {
  constexpr float most_px = 4.0F;
  // Rounding to whole grey levels, in both images.
  constexpr float min_noise_variance = 1.0F / 12.0F;
  const float curvature = 2 * peak.at - peak.before - peak.after;
  const float norm = deviation + damping;
  const float residual = 2 * std::max(norm * (1 - peak.at) - damping, area * min_noise_variance);
  const float sigma = std::min(most_px, std::sqrt(residual / (area * norm * curvature)));
  return curvature > 0 ? sigma : most_px;
}

}  // namespace ilp
