// How well a score tells two classes apart.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace ilp::richness {

struct ScoredImage {
  double score = 0;
  bool interesting = false;
  std::size_t world = 0;  ///< images of one world are not independent of each other
};

struct Auc {
  double value = 0;          ///< chance that an interesting image outranks a plain one, ties half; NaN without both
  double low = 0, high = 0;  ///< 95 % confidence interval
  std::size_t interesting = 0, plain = 0;
};

/// Area under the ROC curve (Mann-Whitney). The interval is the 2.5th to 97.5th percentile of `resamples` bootstrap
/// samples of whole worlds (C. A. Field and A. H. Welsh, "Bootstrapping clustered data", 2007). Deterministic.
[[nodiscard]] Auc area_under_roc(const std::vector<ScoredImage>& images, int resamples = 1000);

/// Points (share of plain images, share of interesting images) at or above a falling threshold, from (0, 0) to (1, 1).
[[nodiscard]] std::vector<std::pair<double, double>> roc_curve(const std::vector<ScoredImage>& images);

/// Spearman's rank correlation, ties with their mean rank. Equally many numbers, at least two.
[[nodiscard]] double rank_correlation(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace ilp::richness
