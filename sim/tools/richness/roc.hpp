// Measures how well a score separates two classes: ROC curve, area under it, and rank correlation.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace ilp::richness {

struct ScoredImage {
  double score = 0;
  bool interesting = false;
  std::size_t world = 0;  ///< for the bootstrap: images of the same world are not independent
};

struct Auc {
  double value = 0;          ///< probability that an interesting image outranks a plain one; NaN if a class is empty
  double low = 0, high = 0;  ///< 95 % confidence interval
  std::size_t interesting = 0, plain = 0;
};

/// Area under the ROC curve (Mann-Whitney; ties count half). The interval is the 2.5th to 97.5th percentile of
/// `resamples` bootstrap samples of complete worlds (C. A. Field and A. H. Welsh, "Bootstrapping clustered data",
/// 2007). Deterministic.
[[nodiscard]] Auc area_under_roc(const std::vector<ScoredImage>& images, int resamples = 1000);

/// Points from (0, 0) to (1, 1): the shares of plain and of interesting images with scores at or above a decreasing
/// threshold.
[[nodiscard]] std::vector<std::pair<double, double>> roc_curve(const std::vector<ScoredImage>& images);

/// Spearman's rank correlation; ties have their mean rank. `a` and `b` must have the same size, at least two.
[[nodiscard]] double rank_correlation(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace ilp::richness
