// When the overlap with the last keyframe will have fallen to its target: the apparent motion of the ground,
// extrapolated from the overlaps measured so far (paper 3.1, "time of the next capture"; decisions.md, 3).
#pragma once

#include <array>

#include "fsw/base/fixed_vector.hpp"
#include "fsw/vision/forecast/apparent_path.hpp"
#include "fsw/vision/forecast/drift_filter.hpp"

namespace ilp {

struct ForecastParams {
  double target_overlap = 0.82;
  double gust_time_s = 40;      ///< how long a gust lasts
  double swing_time_s = 250;    ///< how long a swing remembers its phase
  double shortest_swing_s = 5;  ///< periods that are tried: a gondola on a few to some tens of metres of rope
  double longest_swing_s = 40;
  double misfit = 1.4;         ///< true errors over those that the models expect: real winds are none of them
  double noise_px = 1;         ///< of a measured place: relief and tilt, the registration itself is better
  double tilt_noise_px = 1.5;  ///< of a swing told by the camera's attitude: not all tilt is swing
};

/// Drift and swing cannot be told apart beforehand: many models follow the path side by side, and each counts as much
/// as it has explained (Bayesian model averaging).
class MotionForecast {
 public:
  /// Follows the path from its first trusted place to its last.
  void fit(std::int32_t width, std::int32_t height, const ApparentPath& path, const ForecastParams& params);
  /// Two trusted places at least; otherwise the rest says nothing.
  [[nodiscard]] bool known() const { return known_; }

  struct Overlap {
    double overlap = 1;
    double sigma = 0;  ///< one-sigma error
  };
  /// With a frame taken at this time, not before the last place.
  [[nodiscard]] Overlap overlap_at(TimeNs time_ns) const;
  /// The first time in [earliest, latest] at which the overlap is at or below the target; the latest when there is
  /// none.
  [[nodiscard]] TimeNs time_of_target(TimeNs earliest_ns, TimeNs latest_ns) const;
  /// Of the ground's centre, px of the keyframe.
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

  ForecastParams params_;
  std::int32_t width_ = 0, height_ = 0;
  PathPoint keyframe_, latest_;
  double turn_rad_s_ = 0, growth_per_s_ = 0;
  FixedVector<Hypothesis, most_hypotheses> hypotheses_;  // after the fit only the best, best first
  bool known_ = false;
};

}  // namespace ilp
