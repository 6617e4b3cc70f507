// Predicts where a drifting, swinging camera looks: a Kalman filter along each axis of the ground.
//
// The place is the sum of a drift, whose speed varies about a constant mean (an Ornstein-Uhlenbeck process: wind and
// gusts), and of a swing, an oscillation of known period that gusts sustain (R. E. Kalman, 1960; A. C. Harvey,
// "Forecasting, Structural Time Series Models and the Kalman Filter", 1989, 2.3.3 for the cycle). A camera that is
// rigidly attached to the gondola tilts with the swing: where its attitude is known, the swing is observed separately
// from the drift.
#pragma once

namespace ilp {

struct DriftModel {
  double gust_px_s = 1;        ///< standard deviation of the speed about its mean
  double gust_time_s = 15;     ///< duration of a gust
  double swing_px = 0;         ///< standard deviation of the swing; 0: none
  double swing_rad_s = 0;      ///< its angular frequency
  double swing_time_s = 60;    ///< time over which it keeps its phase
  double noise_px = 1;         ///< of a measured place
  double tilt_noise_px = 1.5;  ///< of the swing that an attitude gives
};

/// Both axes of the ground share one covariance: they are measured at the same times and have the same model.
struct DriftFilter {
  static constexpr int states = 6;  // place of the drift, gust, mean speed; swing, its quadrature; direction at rest
  double mean[2][states] = {};
  double covariance[states][states] = {};
  double log_likelihood = 0;
  int places = 0;  ///< measured
  int tilts = 0;   ///< measured
};

struct Place {
  double x = 0, y = 0;  ///< px
  double variance = 0;  ///< of either, px^2
};

/// Begins with the first place and no other knowledge; speeds beyond `speed_px_s` are unlikely.
void begin_drift(const DriftModel& model, double x, double y, double speed_px_s, DriftFilter& filter);
/// Advances by `seconds`.
void predict_drift(const DriftModel& model, double seconds, DriftFilter& filter);
/// Takes in a measured place. A place far from its prediction gets less weight, so that a single wrong one does not
/// spoil the rest.
void measure_drift(const DriftModel& model, double x, double y, DriftFilter& filter);
/// Takes in where the optical axis points at the time of the last place, px from any direction that stays the same:
/// this is the swing plus an unknown direction at rest.
void measure_tilt(const DriftModel& model, double x, double y, DriftFilter& filter);
/// The place at the present time of the filter.
[[nodiscard]] Place place_of(const DriftFilter& filter);

}  // namespace ilp
