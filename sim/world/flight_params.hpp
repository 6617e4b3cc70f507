// Parameters of a simulated flight. World frame: metres, z up. Camera frame: x right, y down, z forward.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "sim/world/parameter.hpp"

namespace ilp::world {

/// 640x480, 60 degrees wide, no distortion.
[[nodiscard]] CameraModel default_camera();

/// Kinds of flight with their motions:
///   balloon  all motions except the descent: drift with the wind, gusts, swing of the gondola, yaw, altitude
///            oscillation, meander
///   line     an aircraft: drift_m_s along drift_heading_rad at one altitude and attitude
///   hover    a moored balloon: swing, yaw and altitude oscillation over one point
///   descent  constant attitude. Along the optical axis at descent_m_s. With a descent_ratio, straight down with drift
///            instead: the height decreases by the same factor per frame, so that the scale between frames is constant
/// The kinds balloon and line follow a pattern (ground_track.hpp) at the speed of the drift. It begins at the start in
/// the direction of the drift:
///   straight      a line without end
///   lawn-mower    parallel legs of pattern_length_m, each to the left of the one before
///   circle        of the diameter pattern_length_m
///   rectangle     pattern_length_m x pattern_width_m with round corners, from the middle of a long side
///   figure-eight  two circles of the diameter pattern_width_m, pattern_length_m from end to end, from the crossing
///   rosette       straight lines of pattern_length_m through the start, each in another direction
/// A flight in several passes repeats its pattern from the start in every pass, with the same number of frames. In all
/// kinds the optical axis is off_nadir_rad from the nadir. With the defaults consecutive frames overlap by 89 to 99 %,
/// 95 % on average.
struct FlightParams {
  std::uint64_t seed = 1;  ///< of wind, swing and sensor noise
  std::string kind = "balloon";
  int frames = 70;  ///< number of frames, including those that a gap leaves out
  double interval_s = 2;
  CameraModel camera = default_camera();

  double altitude_m = 100;             ///< of the gondola at rest, above z = 0
  double altitude_oscillation = 0.03;  ///< amplitude, share of the altitude
  double altitude_period_s = 200;
  double drift_m_s = 2.5;
  double drift_heading_rad = 0;  ///< from x towards y
  double meander_m = 6;          ///< amplitude across the drift
  double meander_period_s = 240;

  double gust_m_s = 0.07;    ///< standard deviation of the wind's speed, along the drift and across it
  double gust_time_s = 20;   ///< time constant of the gusts' correlation
  double balloon_lag_s = 5;  ///< time constant with which the balloon follows the wind's speed

  double suspension_m = 15;     ///< from the balloon's suspension point to the camera
  double gravity_m_s2 = 3.73;   ///< Mars; period of the swing 2 pi sqrt(suspension / gravity)
  double swing_rad = 0.018;     ///< initial amplitude along the drift; across the drift it is half as large
  double swing_damping = 0.03;  ///< ratio to critical damping
  double yaw_rad = 0.2;         ///< amplitude; at rest the image's x axis points along the drift
  double yaw_period_s = 280;
  double yaw_rate_rad_s = 0;  ///< constant rate in addition

  double off_nadir_rad = 0;          ///< of the optical axis, with the gondola at rest
  double off_nadir_azimuth_rad = 0;  ///< from the image's x axis at rest, counterclockwise seen from above
  double descent_m_s = 0.5;
  double descent_ratio = 0;  ///< first height divided by last height, above z = 0; 0: constant speed
  double descent_drift = 0;  ///< with a descent_ratio: metres along drift_heading_rad for each metre down

  double gap_start_s = 0;   ///< begin of a period without frames
  double gap_length_s = 0;  ///< length of this period; 0: none

  std::string pattern = "straight";
  double pattern_length_m = 300;
  double pattern_width_m = 120;
  double pattern_turn_radius_m = 25;  ///< of lawn-mower, rectangle and rosette
  double side_overlap = 0.3;    ///< of neighbouring legs of a lawn-mower, share of the image's width on the ground
  bool turn_with_track = true;  ///< the camera turns with the pattern's heading; else it keeps its own heading
  double start_x_m = 0;
  double start_y_m = 0;

  int passes = 1;
  double pass_pause_s = 40;         ///< from the end of a pass to the next, without frames
  double pass_altitude = 1;         ///< altitude of a pass divided by that of the pass before
  double pass_heading_rad = 0;      ///< rotation of a pass relative to the pass before, about the pattern's middle
  double pass_yaw_rad = 0;          ///< additional rotation of the camera from pass to pass
  double pass_sun_azimuth_rad = 0;  ///< change of the sun's azimuth from pass to pass

  double revisit = 0;           ///< share of the flight after which it turns back; 0: never
  double revisit_turn_s = 40;   ///< duration of the turn
  double revisit_offset_m = 0;  ///< of the return path from the outward path, to the left
  double revisit_yaw_rad = 0;   ///< rotation of the camera by the turn

  bool altimeter = false;  ///< frames state the height of the camera above the ground
};

/// The fields by name, except the camera.
[[nodiscard]] std::vector<Parameter> parameters(FlightParams& flight);
/// The fields of a camera by name. A negative cx or cy means the image's centre, which `centred` fills in.
[[nodiscard]] std::vector<Parameter> parameters(CameraModel& camera);
[[nodiscard]] CameraModel centred(CameraModel camera);

/// Throws std::invalid_argument that names the first field that is out of range or contradicts another field.
void validate(const FlightParams& flight);

/// Seconds from the first exposure to the last, pauses between passes included.
[[nodiscard]] double flight_length_s(const FlightParams& flight);

}  // namespace ilp::world
