// The fixes of a flight on a map against the true cameras. The map has the coordinates of the truth, as that of a
// simulated world has (ilp-lab world-map).
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

/// A fix is false if its ground point is off by more than `false_px` working pixels and more than `false_sigmas` of
/// what it states.
struct FixScore {
  static constexpr double false_px = 4, false_sigmas = 6;

  std::size_t keyframes = 0;  ///< with a fix record on a map, a final pose and a true camera
  std::size_t fixed = 0, accepted = 0;
  std::size_t false_fixes = 0, false_accepted = 0;
  std::vector<double> ground_px;  ///< of the fixes, error of the ground point in working pixels
  std::vector<double> ground_m;
  std::vector<double> ground_nes;  ///< squares of the same in standard deviations, per axis: 1 on average
  std::vector<double> centre_nes;  ///< likewise of the camera's centre
  std::vector<double> place_m;     ///< of all keyframes whose place is known: the camera's centre by the latest fixes
  std::vector<double> place_nes;
};

/// The ground point of a fix is what the image shows at the flight's principal point. A camera that the flight has
/// found may have it at another pixel than `camera`, the true one; without that, both are the same.
[[nodiscard]] FixScore score_fixes(const intake::Flight& flight, const report::Reference& reference,
                                   const std::optional<CameraModel>& camera = {});

/// Empty where no keyframe had a map.
[[nodiscard]] std::map<std::string, double> fix_summary(const FixScore& score);

}  // namespace ilp::score
