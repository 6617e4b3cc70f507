// Predicts the position of the image's centre for a drifting, swinging camera: a Kalman filter along each axis of the
// ground.
//
// The position is the sum of a drift, whose speed varies about a constant mean (an Ornstein-Uhlenbeck process: wind and
// gusts), and of a swing, an oscillation of known period that gusts sustain (R. E. Kalman, 1960; A. C. Harvey,
// "Forecasting, Structural Time Series Models and the Kalman Filter", 1989, 2.3.3 for the cycle). A camera that is
// rigidly attached to the gondola tilts with the swing: if its attitude is known, the swing is observed separately from
// the drift.
#pragma once

namespace ilp {

struct DriftModel {
  double gust_px_s = 1;        ///< standard deviation of the speed about its mean
  double gust_time_s = 15;     ///< duration of a gust
  double swing_px = 0;         ///< standard deviation of the swing; 0: none
  double swing_rad_s = 0;      ///< angular frequency of the swing
  double swing_time_s = 60;    ///< time over which the swing keeps its phase
  double noise_px = 1;         ///< standard deviation of a measured position
  double tilt_noise_px = 1.5;  ///< standard deviation of the swing from an attitude
};

/// Both axes of the ground have the same covariance: they are measured at the same times and have the same model.
struct DriftFilter {
  static constexpr int states = 6;  // place of the drift, gust, mean speed; swing, its quadrature; direction at rest
  double mean[2][states] = {};
  double covariance[states][states] = {};
  double log_likelihood = 0;
  int places = 0;  ///< number of measured positions
  int tilts = 0;   ///< number of measured directions
};

struct Place {
  double x = 0, y = 0;  ///< px
  double variance = 0;  ///< of each coordinate, px^2
};

/// Starts the filter at the first position. `speed_px_s` is the prior standard deviation of the mean speed.
void begin_drift(const DriftModel& model, double x, double y, double speed_px_s, DriftFilter& filter);
/// Advances by `seconds`.
void predict_drift(const DriftModel& model, double seconds, DriftFilter& filter);
/// Updates the filter with a measured position, px. A position far from its prediction gets less weight, so that a
/// single outlier does little harm.
void measure_drift(const DriftModel& model, double x, double y, DriftFilter& filter);
/// Updates the filter with the direction of the optical axis at the time of the last position, px relative to any
/// constant direction. It is the sum of the swing and an unknown direction at rest.
void measure_tilt(const DriftModel& model, double x, double y, DriftFilter& filter);
/// The position at the present time of the filter.
[[nodiscard]] Place place_of(const DriftFilter& filter);

}  // namespace ilp
