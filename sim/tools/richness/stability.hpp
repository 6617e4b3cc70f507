// Whether the index ranks the same ground equally when it is seen in other ways.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/tools/richness/evaluation.hpp"

namespace ilp::richness {

struct ViewingChange {
  std::string_view name;
  Viewing viewing;
  bool with_depth = true;
};

/// The base, then gains of 0.5 and 2, offsets of 20 grey levels up and down, heights of 0.7 and 1.5, more noise, more
/// haze, exact depth and no depth; the same patches of ground in all.
[[nodiscard]] std::vector<ViewingChange> viewing_changes();

struct StabilityRow {
  std::string_view name;
  Auc auc;                      ///< by the labels of the base
  double rank_correlation = 1;  ///< with the index of the base, over all images
  double mean_change = 0;       ///< of the index
};

/// Every change against the first.
[[nodiscard]] std::vector<StabilityRow> stability(const WorldRange& range, const std::vector<ViewingChange>& changes,
                                                  const RichnessParams& params, std::size_t threads);

[[nodiscard]] std::string stability_table(const std::vector<StabilityRow>& rows);

}  // namespace ilp::richness
