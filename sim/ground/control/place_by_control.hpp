// Strips of a flight placed, scaled and levelled by control points.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/control/control_file.hpp"
#include "sim/ground/intake/flight_model.hpp"

namespace ilp::control {

/// What became of a point in a strip.
struct PointResult {
  std::string name;
  bool check = false;
  bool used = false;
  std::string fault;      ///< why it was not used; empty for one that was, and for a check point that could be measured
  std::size_t marks = 0;  ///< in posed keyframes of the strip
  double rms_px = 0;
  std::optional<Vec3> residual;  ///< place by the fit minus surveyed place, metres: east (x), north (y), up
  double expected_m = 0;         ///< one sigma of it
};

struct StripControl {
  std::int64_t strip = 0;
  bool placed = false;
  std::string fault;  ///< why not
  double metres_per_unit = 0;
  double tilt_sigma_rad = 0;                 ///< one sigma of what is up by the points, about their longest line
  std::vector<PointResult> points;           ///< with a mark in the strip
  double used_rmse_m = 0, check_rmse_m = 0;  ///< three-dimensional; not a number without points
  std::size_t used = 0, checked = 0;
};

/// Moves every strip with three or more agreeing points: its world then has the axes of the points, in metres (for
/// longitude and latitude on `body`: east, north, up about their middle), and `Strip::control` says so. It takes
/// precedence over the place that navigation has given the strip. Strips without enough points stay as they are.
/// std::runtime_error where longitudes need a body and there is none.
[[nodiscard]] std::vector<StripControl> place_by_control(const ControlFile& file, Body body, const std::string& crs,
                                                         intake::Flight& flight);

/// A line for each strip, and one for each point that is wrong.
[[nodiscard]] std::vector<std::string> lines_of(const std::vector<StripControl>& strips);

}  // namespace ilp::control
