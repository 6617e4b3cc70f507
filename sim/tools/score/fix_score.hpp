// Scores the fixes of a flight on a map against the true cameras. The map must have the coordinates of the truth, as
// the map of a simulated world does (ilp-lab world-map).
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/report/accuracy.hpp"

namespace ilp::score {

/// A fix is false if the error of its ground point exceeds `false_px` working pixels and also a Mahalanobis distance of
/// `false_sigmas` by the estimated covariance. NES is the normalised error squared (docs/glossary.md), 1 on average if
/// estimated errors are correct.
struct FixScore {
  static constexpr double false_px = 4, false_sigmas = 6;

  std::size_t keyframes = 0;  ///< keyframes with a fix record on a map, a final pose and a true pose
  std::size_t fixed = 0, accepted = 0;
  std::size_t false_fixes = 0, false_accepted = 0;
  std::vector<double> ground_px;   ///< error of each fix's ground point, working pixels
  std::vector<double> ground_m;    ///< the same in m
  std::vector<double> ground_nes;  ///< NES per axis of the ground point
  std::vector<double> centre_nes;  ///< NES per axis of the fix's camera centre
  std::vector<double> place_m;     ///< horizontal error of the centre from the latest fixes, where the flight has it
  std::vector<double> place_nes;   ///< NES per axis of the same
};

/// The ground point of a fix is the ground at the principal point of the flight's camera. `camera` is the true camera,
/// in which this pixel may not be the principal point; if empty, both have the same principal point.
[[nodiscard]] FixScore score_fixes(const intake::Flight& flight, const report::Reference& reference,
                                   const std::optional<CameraModel>& camera = {});

/// Numbers for the summary of a score; empty if no keyframe had a map.
[[nodiscard]] std::map<std::string, double> fix_summary(const FixScore& score);

}  // namespace ilp::score
