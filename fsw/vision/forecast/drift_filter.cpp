#include "fsw/vision/forecast/drift_filter.hpp"

#include <cmath>

#include "fsw/base/math.hpp"

namespace ilp {
namespace {

constexpr int n = DriftFilter::states;
// In standard deviations. Beyond it the error counts linearly instead of quadratically (P. J. Huber, 1964).
constexpr double trusted_innovation = 3;

// px: any direction of the camera at rest.
constexpr double direction_px = 1e3;

constexpr int drift = 0, gust = 1, mean_speed = 2, swing = 3, quadrature = 4, at_rest = 5;

/// Takes in the sum of two states. `counts`: the measurement enters the likelihood, unless it fixes an unknown state.
void measure(int first, int second, const double (&value)[2], double noise_px, bool counts, DriftFilter& filter) {
  double gain[n] = {};
  for (int i = 0; i < n; ++i) gain[i] = filter.covariance[i][first] + filter.covariance[i][second];
  double variance = gain[first] + gain[second] + noise_px * noise_px;
  const double innovation[2] = {value[0] - filter.mean[0][first] - filter.mean[0][second],
                                value[1] - filter.mean[1][first] - filter.mean[1][second]};
  const double squares = innovation[0] * innovation[0] + innovation[1] * innovation[1];
  const double ratio = std::sqrt(squares / variance);
  const bool outlier = ratio > trusted_innovation;
  if (counts) {
    const double misfit = outlier ? trusted_innovation * (ratio - 0.5 * trusted_innovation) : 0.5 * ratio * ratio;
    filter.log_likelihood -= det_log(variance) + misfit;
  }
  if (outlier) variance *= ratio * ratio / (trusted_innovation * trusted_innovation);
  for (int axis = 0; axis < 2; ++axis) {
    for (int i = 0; i < n; ++i) filter.mean[axis][i] += gain[i] / variance * innovation[axis];
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) filter.covariance[i][j] -= gain[i] * gain[j] / variance;
  }
}

}  // namespace

void begin_drift(const DriftModel& model, double x, double y, double speed_px_s, DriftFilter& filter) {
  filter = {};
  filter.mean[0][drift] = x;
  filter.mean[1][drift] = y;
  const double swing_variance = model.swing_px * model.swing_px;
  filter.covariance[drift][drift] = swing_variance + model.noise_px * model.noise_px;
  // The first place fixes the sum of drift and swing.
  filter.covariance[swing][swing] = swing_variance;
  filter.covariance[drift][swing] = filter.covariance[swing][drift] = -swing_variance;
  filter.covariance[quadrature][quadrature] = swing_variance;
  filter.covariance[gust][gust] = model.gust_px_s * model.gust_px_s;
  filter.covariance[mean_speed][mean_speed] = speed_px_s * speed_px_s;
  filter.covariance[at_rest][at_rest] = direction_px * direction_px;
  filter.places = 1;
}

void predict_drift(const DriftModel& model, double seconds, DriftFilter& filter) {
  const double keep = det_exp(-seconds / model.gust_time_s);
  const double fade = det_exp(-seconds / model.swing_time_s);
  const double c = fade * det_cos(model.swing_rad_s * seconds);
  const double s = fade * det_sin(model.swing_rad_s * seconds);
  const double f[n][n] = {{1, model.gust_time_s * (1 - keep), seconds, 0, 0, 0},
                          {0, keep, 0, 0, 0, 0},
                          {0, 0, 1, 0, 0, 0},
                          {0, 0, 0, c, s, 0},
                          {0, 0, 0, -s, c, 0},
                          {0, 0, 0, 0, 0, 1}};
  for (auto& mean : filter.mean) {
    double moved[n] = {};
    for (int i = 0; i < n; ++i) {
      for (int k = 0; k < n; ++k) moved[i] += f[i][k] * mean[k];
    }
    for (int i = 0; i < n; ++i) mean[i] = moved[i];
  }
  double fp[n][n] = {};
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < n; ++k) {
      if (f[i][k] == 0) continue;
      for (int j = 0; j < n; ++j) fp[i][j] += f[i][k] * filter.covariance[k][j];
    }
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      double sum = 0;
      for (int k = 0; k < n; ++k) sum += fp[i][k] * f[j][k];
      filter.covariance[i][j] = sum;
    }
  }
  // The integral of the gust (C. W. Gardiner, "Stochastic Methods", 3.8.4).
  const double variance = model.gust_px_s * model.gust_px_s;
  const double lasting = model.gust_time_s;
  const double place_gust = variance * lasting * (1 - keep) * (1 - keep);
  filter.covariance[drift][drift] += variance * lasting * (2 * seconds - lasting * (3 - 4 * keep + keep * keep));
  filter.covariance[drift][gust] += place_gust;
  filter.covariance[gust][drift] += place_gust;
  filter.covariance[gust][gust] += variance * (1 - keep * keep);
  const double kick = model.swing_px * model.swing_px * (1 - fade * fade);
  filter.covariance[swing][swing] += kick;
  filter.covariance[quadrature][quadrature] += kick;
}

void measure_drift(const DriftModel& model, double x, double y, DriftFilter& filter) {
  // The second place fixes the mean speed, which was unknown.
  measure(drift, swing, {x, y}, model.noise_px, filter.places > 1, filter);
  ++filter.places;
}

void measure_tilt(const DriftModel& model, double x, double y, DriftFilter& filter) {
  measure(swing, at_rest, {x, y}, model.tilt_noise_px, filter.tilts > 0, filter);
  ++filter.tilts;
}

Place place_of(const DriftFilter& filter) {
  return {filter.mean[0][drift] + filter.mean[0][swing], filter.mean[1][drift] + filter.mean[1][swing],
          filter.covariance[drift][drift] + 2 * filter.covariance[drift][swing] + filter.covariance[swing][swing]};
}

}  // namespace ilp
