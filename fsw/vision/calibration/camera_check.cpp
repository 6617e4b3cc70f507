#include "fsw/vision/calibration/camera_check.hpp"

#include <cmath>

#include "fsw/vision/calibration/camera_system.hpp"

namespace ilp {
namespace {

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

void add_window(const IntrinsicsEquations& window, CameraEvidence& evidence) {
  constexpr std::uint32_t least_points = 50;
  if (window.points < least_points) return;
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

LensExcess excess_of(double statistic, double spread, double field) {
  constexpr double spread_of_statistic = 0.05, field_of_statistic = 0.005;  // what a wrong lens may leave
  return {spread / std::fmax(max_camera_spread, spread_of_statistic * statistic),
          field / (max_camera_field * (1 + field_of_statistic * statistic))};
}

CameraCheck judge(const CameraEvidence& evidence, const CameraModel& given) {
  CameraCheck out;
  if (evidence.windows == 0) return out;
  constexpr double prior_of_statistic = 1e-6, rounding = 1e-12;
  const CameraUnknowns& gradient = evidence.gradient;
  CameraSystem information, held, with_prior;
  std::size_t at = 0;
  for (std::size_t a = 0; a < camera_unknowns; ++a) {
    for (std::size_t b = 0; b <= a; ++b) information.at(a, b) = information.at(b, a) = evidence.information[at++];
  }
  held = with_prior = information;
  for (std::size_t a = 0; a < camera_unknowns; ++a) {
    held.at(a, a) += prior_of_statistic + rounding * information.at(a, a);
    with_prior.at(a, a) += 1;
  }
  // What is no number is no evidence for the camera.
  if (!held.factor() || !with_prior.factor()) {
    out.verdict = CameraCheckVerdict::unexplained;
    return out;
  }
  const CameraUnknowns own = held.solve(gradient);
  CameraUnknowns correction = with_prior.solve(gradient);
  for (double& value : correction) value = -value;
  double gained = 0;
  for (std::size_t a = 0; a < camera_unknowns; ++a) gained += gradient[a] * own[a];
  const CameraUnknowns units = usual_errors(given);
  double most = -1;
  for (std::size_t a = 0; a < camera_unknowns; ++a) {
    out.corrections[a] = correction[a] * units[a];
    out.sigmas[a] = std::sqrt(with_prior.column_of_inverse(a)[a]) * units[a];
    if (a == readout_unknown) continue;
    const double alone = gradient[a] * gradient[a] / (information.at(a, a) + 1);
    if (!(alone > most)) continue;
    most = alone;
    out.worst = static_cast<Intrinsic>(a);
    out.worst_correction = -gradient[a] / (information.at(a, a) + 1) * units[a];
    out.worst_sigmas = std::sqrt(alone);
  }
  double displaced = 0;
  at = 0;
  for (std::size_t a = 0; a < camera_unknowns; ++a) {
    for (std::size_t b = 0; b < a; ++b) displaced += 2 * correction[a] * correction[b] * evidence.displacement[at++];
    displaced += correction[a] * correction[a] * evidence.displacement[at++];
  }
  out.cost = std::sqrt(std::fmax(displaced, 0) / evidence.windows);
  constexpr double least_information = 1e-3;
  const bool asks_readout = information.at(readout_unknown, readout_unknown) > least_information;
  const auto unknowns = static_cast<double>(intrinsic_count + (asks_readout ? 1 : 0));
  out.statistic = gained / unknowns;
  if (evidence.windows > 1) {
    out.spread = std::fmax(evidence.gained - gained, 0) / (unknowns * (evidence.windows - 1));
  }
  out.field = field_of(evidence.field);
  out.noise_px = std::sqrt(evidence.noise2_px / evidence.windows);
  const bool accused = !(out.statistic <= max_camera_statistic);
  const bool no_lens = excess_of(out.statistic, out.spread, out.field).largest() > 1;
  out.verdict = no_lens   ? CameraCheckVerdict::unexplained
                : accused ? CameraCheckVerdict::contradicts
                          : CameraCheckVerdict::fits;
  return out;
}

}  // namespace ilp
