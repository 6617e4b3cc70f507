#include "fsw/vision/calibration/camera_check.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace ilp {
namespace {

using MatU = Eigen::Matrix<double, static_cast<int>(camera_unknowns), static_cast<int>(camera_unknowns)>;
using VecU = Eigen::Matrix<double, static_cast<int>(camera_unknowns), 1>;

double field_of(const ResidualField& field) {
  constexpr double least_weight = 20;
  if (!(field.squared > 0)) return 0;
  double sum = 0;
  int coordinates = 0;
  for (const ResidualField::Cell& cell : field.cells) {
    if (cell.weight <= least_weight) continue;
    sum += (cell.x * cell.x + cell.y * cell.y) / cell.weight;
    coordinates += 2;
  }
  const double variance = field.squared / (2 * field.weight);
  return coordinates == 0 ? 0 : std::sqrt(sum / (coordinates * variance));
}

}  // namespace

void add_window(const IntrinsicsEquations& window, const CameraCheckParams& params, CameraEvidence& evidence) {
  if (window.points < params.least_points) return;
  std::size_t at = 0;
  for (std::size_t a = 0; a < camera_unknowns; ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      evidence.displacement[at] += window.displacement[a][b];
      evidence.information[at++] += window.information[a][b];
    }
    evidence.gradient[a] += window.gradient[a];
  }
  evidence.gained += window.gained;
  evidence.noise2_px += window.noise_px * window.noise_px;
  ++evidence.windows;
  evidence.points += window.points;
}

CameraCheck judge(const CameraEvidence& evidence, const CameraModel& given, const CameraCheckParams& params) {
  CameraCheck out;
  if (evidence.windows == 0) return out;
  constexpr double prior_of_statistic = 1e-6;
  MatU information;
  VecU gradient;
  std::size_t at = 0;
  for (std::size_t a = 0; a < camera_unknowns; ++a) {
    const auto i = static_cast<int>(a);
    gradient[i] = evidence.gradient[a];
    for (std::size_t b = 0; b <= a; ++b) {
      information(i, static_cast<int>(b)) = information(static_cast<int>(b), i) = evidence.information[at++];
    }
  }
  MatU held = information;
  held.diagonal().array() += prior_of_statistic;
  const double gained = gradient.dot(held.llt().solve(gradient));
  held.diagonal().array() += 1 - prior_of_statistic;
  const Eigen::LLT<MatU> with_prior(held);
  const VecU correction = -with_prior.solve(gradient);
  const MatU covariance = with_prior.solve(MatU::Identity());
  const CameraUnknowns units = usual_errors(given);
  double most = -1;
  for (std::size_t a = 0; a < camera_unknowns; ++a) {
    const auto i = static_cast<int>(a);
    out.corrections[a] = correction[i] * units[a];
    out.sigmas[a] = std::sqrt(covariance(i, i)) * units[a];
    if (a == readout_unknown) continue;
    const double alone = gradient[i] * gradient[i] / (information(i, i) + 1);
    if (!(alone > most)) continue;
    most = alone;
    out.worst = static_cast<Intrinsic>(a);
    out.worst_correction = -gradient[i] / (information(i, i) + 1) * units[a];
    out.worst_sigmas = std::sqrt(alone);
  }
  double displaced = 0;
  at = 0;
  for (int i = 0; i < correction.rows(); ++i) {
    for (int k = 0; k < i; ++k) displaced += 2 * correction[i] * correction[k] * evidence.displacement[at++];
    displaced += correction[i] * correction[i] * evidence.displacement[at++];
  }
  out.cost = std::sqrt(std::fmax(displaced, 0) / evidence.windows);
  constexpr double least_information = 1e-3;
  const auto last = static_cast<int>(readout_unknown);
  const auto unknowns = static_cast<double>(intrinsic_count + (information(last, last) > least_information ? 1 : 0));
  out.statistic = gained / unknowns;
  if (evidence.windows > 1) {
    out.spread = std::fmax(evidence.gained - gained, 0) / (unknowns * (evidence.windows - 1));
  }
  out.field = field_of(evidence.field);
  out.noise_px = std::sqrt(evidence.noise2_px / evidence.windows);
  const bool accused = !(out.statistic <= params.max_statistic);
  // A large correction is found only roughly by one step, which leaves something in windows and residuals.
  const bool no_lens = out.spread > std::fmax(params.max_spread, params.spread_of_statistic * out.statistic) ||
                       out.field > params.max_field * (1 + params.field_of_statistic * out.statistic);
  out.verdict = no_lens   ? CameraCheckVerdict::unexplained
                : accused ? CameraCheckVerdict::contradicts
                          : CameraCheckVerdict::fits;
  return out;
}

}  // namespace ilp
