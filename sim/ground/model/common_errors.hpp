// Estimates how much the errors of neighbouring sightings in an image are correlated.
#pragma once

#include <array>
#include <cstddef>

#include "sim/ground/model/adjustment.hpp"

namespace ilp::model {

/// The ratio of the variance of sums of residuals over a part of an image to the variance that independent errors would
/// give (the design effect of cluster samples; L. Kish, "Survey Sampling", 1965, 5.4). Each image has a small
/// distortion of its own, so that many points in one place measure no more than few. Parts are squares with a fourth,
/// an eighth and a sixteenth of the image's width; the largest ratio is used. The objects of parts of a model that
/// share no points can be added.
struct CommonErrors {
  struct InParts {
    double of_sums = 0;                     ///< sum over parts of (sum of residuals)^2, px^2
    double independent = 0;                 ///< sum of squared residuals, px^2
    double counts = 0, squared_counts = 0;  ///< sums of the numbers of residuals in a part, and of twice their squares
  };
  static constexpr std::array<double, 3> parts_per_width = {4, 8, 16};
  std::array<InParts, parts_per_width.size()> in_parts;

  void add(const CommonErrors& other);
  /// The largest ratio; 1 if none exceeds 1 by more than three of its standard deviations under independent errors.
  [[nodiscard]] double factor() const;
};

/// From the residuals of the observations, weighted by Cauchy's loss of scale `robust_px`.
[[nodiscard]] CommonErrors common_errors_of(const AdjustmentProblem& problem, double robust_px);

}  // namespace ilp::model
