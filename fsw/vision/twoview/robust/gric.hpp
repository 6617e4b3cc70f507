// The geometric robust information criterion (GRIC): compares models of different size on the same matches. Source: P.
// Torr, "An Assessment of Information Criteria for Motion Model Selection", CVPR 1997; "Geometric Motion Segmentation
// and Model Selection", 1998.
#pragma once

#include <cstddef>

namespace ilp {

/// Dimension of the model's manifold in the space of matches, and number of parameters.
struct GricModel {
  double dimension;
  double parameters;
};
inline constexpr GricModel gric_fundamental{3, 7};
inline constexpr GricModel gric_essential{3, 5};
inline constexpr GricModel gric_homography{2, 8};
inline constexpr GricModel gric_rotation{2, 3};

/// GRIC = sum min(e^2 / sigma^2, l3 (r - d)) + l1 d n + l2 k, with r = 4 coordinates a match, l1 = ln r, l2 = ln(r n),
/// l3 = 2. `add` takes the squared Sampson distances (px^2) of the matches from the manifold, in their order. The model
/// with the smallest value is preferred.
class Gric {
 public:
  Gric(const GricModel& model, double sigma_px) : model_(model), variance_(sigma_px * sigma_px) {}
  void add(double squared_px);
  [[nodiscard]] double value() const;

 private:
  GricModel model_;
  double variance_;
  double residuals_ = 0;
  double count_ = 0;
};

}  // namespace ilp
