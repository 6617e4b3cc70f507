#include "fsw/vision/calibration/lens_solution.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "fsw/vision/geometry/camera.hpp"

namespace ilp {
namespace {

using MatI = Eigen::Matrix<double, static_cast<int>(intrinsic_count), static_cast<int>(intrinsic_count)>;
using VecI = Eigen::Matrix<double, static_cast<int>(intrinsic_count), 1>;

/// How far one step may go, the equations being linear only nearby.
Intrinsics longest_step(const CameraModel& camera) {
  return {0.06 * camera.fx, 0.025 * camera.width, 0.025 * camera.width, 0.1, 0.1, 0.003, 0.003};
}

Intrinsics intrinsics_of(const CameraModel& c) {
  return {c.fx, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2};
}

}  // namespace

LensPrior prior_of(const CameraModel& nominal, double focal_sigma) {
  LensPrior prior{nominal, usual_errors(nominal)};
  prior.sigmas[0] = focal_sigma * nominal.fx;
  return prior;
}

LensStep step_towards_lens(const CameraEvidence& evidence, const CameraModel& now, const LensPrior& prior,
                           double misfit) {
  const Intrinsics units = usual_errors(now);
  const Intrinsics at_now = intrinsics_of(now), before = intrinsics_of(prior.camera);
  const double trust = 1 / std::fmax(1, misfit);
  MatI information;
  VecI gradient;
  std::size_t at = 0;
  for (std::size_t a = 0; a < intrinsic_count; ++a) {
    const auto i = static_cast<int>(a);
    for (std::size_t b = 0; b <= a; ++b) {
      information(i, static_cast<int>(b)) = information(static_cast<int>(b), i) = trust * evidence.information[at++];
    }
    const double known = units[a] / prior.sigmas[a];
    information(i, i) += known * known;
    gradient[i] = trust * evidence.gradient[a] + known * (at_now[a] - before[a]) / prior.sigmas[a];
  }
  const Eigen::LLT<MatI> factor(information);
  const VecI correction = -factor.solve(gradient);
  const MatI covariance = factor.solve(MatI::Identity());
  LensStep out;
  const Intrinsics longest = longest_step(now);
  double scale = 1;
  at = 0;
  for (std::size_t a = 0; a < intrinsic_count; ++a) {
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
    Intrinsics step;
    for (std::size_t a = 0; a < intrinsic_count; ++a) step[a] = scale * correction[static_cast<int>(a)] * units[a];
    out.camera = corrected(now, step);
    if (validate(out.camera).ok()) return out;
    out.shortened = true;
  }
  out.camera = now;
  return out;
}

}  // namespace ilp
