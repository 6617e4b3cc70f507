// The numbers of a flight's score (score.json, "summary"): what they are called for people, and which values are bad.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ilp::batch {

enum class Better { lower, higher, nearer, neither };

struct SummaryKey {
  std::string_view name;
  std::string_view label;  ///< with the unit
  Better better = Better::lower;
  double ideal = 0;  ///< for `nearer`
};

[[nodiscard]] std::span<const SummaryKey> summary_keys();
/// nullptr: no such key.
[[nodiscard]] const SummaryKey* find_summary_key(std::string_view name);
/// For messages: all names, separated by commas.
[[nodiscard]] std::string summary_key_list();
/// The value that is farthest from good; NaN for no values, and where no value is better than another.
[[nodiscard]] double worst_of(const SummaryKey& key, const std::vector<double>& values);

}  // namespace ilp::batch
