#include "fsw/vision/calibration/lens_solution.hpp"

#include <cmath>

#include "fsw/vision/calibration/camera_system.hpp"
#include "fsw/vision/geometry/camera.hpp"

namespace ilp {
namespace {

/// An unknown of a smaller error stays where it is.
constexpr double least_share_of_unit = 1e-4;

/// How far one step may go, the equations being linear only nearby.
CameraUnknowns longest_step(const CameraModel& camera) {
  return {0.06 * camera.fx, 0.025 * camera.width, 0.025 * camera.width, 0.1, 0.1, 0.003, 0.003, 0.05};
}

CameraUnknowns unknowns_of(const CameraModel& c) {
  return {c.fx, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2, c.readout_s};
}

}  // namespace

LensPrior prior_of(const CameraModel& nominal, const KnownOfCamera& known) {
  LensPrior prior{nominal, usual_errors(nominal)};
  if (known.lens) prior.sigmas.fill(0);
  if (!known.lens) prior.sigmas[0] = known.focal_sigma * nominal.fx;
  prior.sigmas[readout_unknown] = known.readout_sigma_s;
  return prior;
}

LensStep step_towards_lens(const CameraEvidence& evidence, const CameraModel& now, const LensPrior& prior,
                           double misfit) {
  const CameraUnknowns units = usual_errors(now);
  const CameraUnknowns at_now = unknowns_of(now), before = unknowns_of(prior.camera);
  const double trust = 1 / std::fmax(1, misfit);
  CameraSystem system;
  CameraUnknowns gradient;
  std::size_t at = 0;
  for (std::size_t a = 0; a < camera_unknowns; ++a) {
    for (std::size_t b = 0; b <= a; ++b) system.at(a, b) = trust * evidence.information[at++];
    const double sigma = std::fmax(prior.sigmas[a], least_share_of_unit * units[a]), known = units[a] / sigma;
    system.at(a, a) += known * known;
    gradient[a] = trust * evidence.gradient[a] + known * (at_now[a] - before[a]) / sigma;
  }
  LensStep out;
  out.camera = now;
  out.sigmas = prior.sigmas;
  out.lens_sigma = prior.sigmas[3];
  for (std::size_t a = 0; a < camera_unknowns; ++a) out.covariance[a * (a + 3) / 2] = out.sigmas[a] * out.sigmas[a];
  // What is no number is no evidence.
  if (!system.factor()) return out;
  const CameraUnknowns correction = system.solve(gradient);
  const CameraUnknowns longest = longest_step(now);
  double scale = 1;
  at = 0;
  for (std::size_t a = 0; a < camera_unknowns; ++a) {
    const CameraUnknowns covariance = system.column_of_inverse(a);
    const double sigma = std::sqrt(covariance[a]);
    out.sigmas[a] = sigma * units[a];
    out.length = std::fmax(out.length, std::fabs(correction[a]) / sigma);
    scale = std::fmin(scale, longest[a] / std::fmax(std::fabs(correction[a]) * units[a], 1e-12));
    for (std::size_t b = 0; b <= a; ++b) out.covariance[at++] = covariance[b] * units[a] * units[b];
  }
  const CameraUnknowns of_focal = system.column_of_inverse(0), of_k1 = system.column_of_inverse(3);
  out.lens_sigma = std::sqrt(std::fmax(of_k1[3] - of_focal[3] * of_focal[3] / of_focal[0], 0)) * units[3];
  out.shortened = scale < 1;
  constexpr int halvings = 4;
  for (int i = 0; i <= halvings; ++i, scale *= 0.5) {
    CameraUnknowns step;
    for (std::size_t a = 0; a < camera_unknowns; ++a) step[a] = -scale * correction[a] * units[a];
    out.camera = corrected(now, step);
    if (validate(out.camera).ok()) return out;
    out.shortened = true;
  }
  out.camera = now;
  return out;
}

}  // namespace ilp
