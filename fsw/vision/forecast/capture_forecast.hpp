// Predicts when the overlap with the last keyframe falls to its target. The apparent motion of the ground is
// extrapolated from the overlaps measured so far (paper 3.1, "time of the next capture"; decisions.md, 3).
#pragma once

#include <array>

#include "fsw/base/fixed_vector.hpp"
#include "fsw/vision/forecast/apparent_path.hpp"
#include "fsw/vision/forecast/drift_filter.hpp"

namespace ilp {

/// The shares of drift and swing in the motion are unknown. Many models therefore follow the path in parallel, each
/// weighted by its likelihood (Bayesian model averaging).
class MotionForecast {
 public:
  /// Fits the models to the path, from its first trusted point to its last.
  void fit(std::int32_t width, std::int32_t height, const ApparentPath& path, double target_overlap);
  /// True if the path has at least two trusted points. Otherwise the functions below are meaningless.
  [[nodiscard]] bool known() const { return known_; }

  struct Overlap {
    double overlap = 1;  ///< 0 to 1
    double sigma = 0;    ///< standard deviation
  };
  /// Overlap of the keyframe with a frame exposed at this time, which must not be before the last point.
  [[nodiscard]] Overlap overlap_at(TimeNs time_ns) const;
  /// First time in [earliest_ns, latest_ns] at which the overlap is at or below the target; `latest_ns` if there is
  /// none.
  [[nodiscard]] TimeNs time_of_target(TimeNs earliest_ns, TimeNs latest_ns) const;
  /// Speed of the image's centre over the ground, in px of the keyframe per second.
  [[nodiscard]] double speed_px_s() const;

 private:
  struct Hypothesis {
    DriftModel model;
    DriftFilter filter;
    double weight = 0;
  };
  static constexpr std::size_t swing_periods = 48;
  static constexpr std::size_t swing_sizes = 3;
  static constexpr std::size_t gust_sizes = 3;
  static constexpr std::size_t most_hypotheses = gust_sizes * (1 + swing_periods * swing_sizes);
  static constexpr std::size_t kept = 24;

  void make_hypotheses(std::int32_t width, double speed_px_s);
  void follow(const ApparentPath& path, Hypothesis& hypothesis, double speed_px_s) const;
  void keep_best();
  void fit_attitude(const ApparentPath& path);

  double target_overlap_ = 1;
  std::int32_t width_ = 0, height_ = 0;
  PathPoint keyframe_, latest_;
  double turn_rad_s_ = 0, growth_per_s_ = 0;
  FixedVector<Hypothesis, most_hypotheses> hypotheses_;  // after the fit only the best, best first
  bool known_ = false;
};

}  // namespace ilp
