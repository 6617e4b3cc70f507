#include "fsw/vision/twoview/robust/chance_matches.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/vision/twoview/refine/match_error.hpp"

namespace ilp {

double median_of(FixedVector<double, limits::max_matches>& values) {
  if (values.empty()) return 0;
  double* middle = values.begin() + values.size() / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

bool remove_chance_matches(const NormalisedPairs& all, const NormalisedPairs& supported, const Mat3& homography,
                           double threshold_px, double bound_px, double image_side_px,
                           FixedVector<double, limits::max_matches>& errors, PairIndices& kept) {
  errors.clear();
  for (const NormalisedPair& pair : supported.exact) {
    static_cast<void>(errors.push_back(std::sqrt(transfer_squared(homography, pair, all.scale))));
  }
  const double limit_px = std::fmax(8 * median_of(errors), 4 * threshold_px);
  double suspects = 0;
  for (const double error : errors) suspects += error > limit_px ? 1 : 0;
  const double share_on_line = 2 * bound_px / image_side_px;
  const double expected = share_on_line * static_cast<double>(all.size() - supported.size());
  if (suspects > expected + 3 * std::sqrt(expected) + 1) return false;
  kept.clear();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!(transfer_squared(homography, all.exact[i], all.scale) <= limit_px * limit_px)) continue;
    static_cast<void>(kept.push_back(static_cast<std::uint16_t>(i)));
  }
  return true;
}

}  // namespace ilp
