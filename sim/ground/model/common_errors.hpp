// Errors that neighbouring sightings of an image have in common.
#pragma once

#include <array>
#include <cstddef>

#include "sim/ground/model/adjustment.hpp"

namespace ilp::model {

/// By how much the variance of sums of residuals over a part of an image exceeds what independent errors would give
/// (the design effect of cluster samples; L. Kish, "Survey Sampling", 1965, 5.4). Images are bent a little, each in its
/// own way, and many points in one place tell no more than few. Parts are squares of a fourth, an eighth and a
/// sixteenth of the image's width; the largest ratio counts. The sums of parts of a model, each with points of its own,
/// add up to those of the model.
struct CommonErrors {
  struct InParts {
    double of_sums = 0;      ///< squares of the sums of residuals over parts
    double independent = 0;  ///< squares of residuals
    double counts = 0, squared_counts = 0;
  };
  static constexpr std::array<double, 3> parts_per_width = {4, 8, 16};
  std::array<InParts, parts_per_width.size()> in_parts;

  void add(const CommonErrors& other);
  /// 1 where no ratio is larger than independent errors explain, by three of its standard deviations.
  [[nodiscard]] double factor() const;
};

/// Residuals count less by Cauchy's loss of scale `robust_px`.
[[nodiscard]] CommonErrors common_errors_of(const AdjustmentProblem& problem, double robust_px);

}  // namespace ilp::model
