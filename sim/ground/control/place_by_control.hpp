// Places, scales and levels the strips of a flight by control points.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/control/control_file.hpp"
#include "sim/ground/intake/flight_model.hpp"

namespace ilp::control {

/// Result for one control point in one strip.
struct PointResult {
  std::string name;
  bool check = false;            ///< a check point
  bool used = false;             ///< used to place the strip
  std::string fault;             ///< why it was not used; empty: used, or a check point that was measured
  std::size_t marks = 0;         ///< number of marks in posed keyframes of the strip
  double rms_px = 0;             ///< RMS reprojection error of the marks
  std::optional<Vec3> residual;  ///< position by the fit minus surveyed position, metres: east (x), north (y), up
  double expected_m = 0;         ///< standard deviation of the residual (3D) from the errors of survey and marks
};

struct StripControl {
  std::int64_t strip = 0;
  bool placed = false;
  std::string fault;  ///< why it was not placed
  double metres_per_unit = 0;
  double tilt_sigma_rad = 0;                 ///< standard deviation of the vertical about the points' longest axis
  std::vector<PointResult> points;           ///< the points with a mark in the strip
  double used_rmse_m = 0, check_rmse_m = 0;  ///< RMS 3D residuals of used points and of check points; NaN: none
  std::size_t used = 0, checked = 0;         ///< numbers of these points
};

/// Moves every strip with three or more agreeing points (fit_control), and sets its Strip::control. Its world then has
/// the axes of the points in metres; for longitude and latitude on `body` these are east, north and up about the middle
/// of the points. This replaces a position by navigation or by a map. Other strips do not change. `crs`: system of
/// longitude and latitude, for GDAL. Throws std::runtime_error if the points have longitude and latitude and `crs` is
/// empty.
[[nodiscard]] std::vector<StripControl> place_by_control(const ControlFile& file, Body body, const std::string& crs,
                                                         intake::Flight& flight);

/// Lines for the user: one for each strip, and one for each point with a fault.
[[nodiscard]] std::vector<std::string> lines_of(const std::vector<StripControl>& strips);

}  // namespace ilp::control
