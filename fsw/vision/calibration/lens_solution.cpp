#include "fsw/vision/calibration/lens_solution.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "fsw/vision/geometry/camera.hpp"

namespace ilp {
namespace {

using MatU = Eigen::Matrix<double, static_cast<int>(camera_unknowns), static_cast<int>(camera_unknowns)>;
using VecU = Eigen::Matrix<double, static_cast<int>(camera_unknowns), 1>;

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
  MatU information;
  VecU gradient;
  std::size_t at = 0;
  for (std::size_t a = 0; a < camera_unknowns; ++a) {
    const auto i = static_cast<int>(a);
    for (std::size_t b = 0; b <= a; ++b) {
      information(i, static_cast<int>(b)) = information(static_cast<int>(b), i) = trust * evidence.information[at++];
    }
    const double sigma = std::fmax(prior.sigmas[a], least_share_of_unit * units[a]), known = units[a] / sigma;
    information(i, i) += known * known;
    gradient[i] = trust * evidence.gradient[a] + known * (at_now[a] - before[a]) / sigma;
  }
  const Eigen::LLT<MatU> factor(information);
  const VecU correction = -factor.solve(gradient);
  const MatU covariance = factor.solve(MatU::Identity());
  LensStep out;
  const CameraUnknowns longest = longest_step(now);
  double scale = 1;
  at = 0;
  for (std::size_t a = 0; a < camera_unknowns; ++a) {
    const auto i = static_cast<int>(a);
    const double sigma = std::sqrt(covariance(i, i));
    out.sigmas[a] = sigma * units[a];
    out.length = std::fmax(out.length, std::fabs(correction[i]) / sigma);
    scale = std::fmin(scale, longest[a] / std::fmax(std::fabs(correction[i]) * units[a], 1e-12));
    for (std::size_t b = 0; b <= a; ++b)
      out.covariance[at++] = covariance(i, static_cast<int>(b)) * units[a] * units[b];
  }
  const double shared = covariance(3, 0) * covariance(3, 0) / covariance(0, 0);
  out.lens_sigma = std::sqrt(std::fmax(covariance(3, 3) - shared, 0)) * units[3];
  out.shortened = scale < 1;
  constexpr int halvings = 4;
  for (int i = 0; i <= halvings; ++i, scale *= 0.5) {
    CameraUnknowns step;
    for (std::size_t a = 0; a < camera_unknowns; ++a) step[a] = scale * correction[static_cast<int>(a)] * units[a];
    out.camera = corrected(now, step);
    if (validate(out.camera).ok()) return out;
    out.shortened = true;
  }
  out.camera = now;
  return out;
}

}  // namespace ilp
