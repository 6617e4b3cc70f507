// What a simulated flight does. World frame: metres, z up; camera: x right, y down, z forward.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "sim/world/parameter.hpp"

namespace ilp::world {

/// 640x480, 60 degrees wide, no distortion.
[[nodiscard]] CameraModel default_camera();

/// Kinds of flight, and what moves the camera in them:
///   balloon  all of the below but the descent: it drifts with the wind, gusts push it, the gondola swings below it
///   line     an aircraft: drift_m_s along drift_heading_rad at one altitude and attitude
///   hover    a moored balloon: swing, yaw and altitude oscillation over one place
///   descent  attitude unchanged. Along the optical axis at descent_m_s or, with a descent_ratio, straight down with
///            drift: the height shrinks by the same factor in equal times, so that the scale between frames is planned
/// A balloon or a line follows a pattern (ground_track.hpp) from the start in the direction of the drift, at the speed
/// of the drift:
///   straight      on and on
///   lawn-mower    parallel legs of pattern_length_m, each to the left of the one before
///   circle        of the diameter pattern_length_m
///   rectangle     pattern_length_m x pattern_width_m with round corners, from the middle of a long side
///   figure-eight  two circles of the diameter pattern_width_m, pattern_length_m from end to end, from the crossing
///   rosette       straight lines of pattern_length_m through the start, each in another direction
/// A flight in several passes flies its pattern as often, each time from the start, in equal numbers of frames.
/// The camera looks off_nadir_rad from straight below in all of them. With the defaults consecutive frames overlap by
/// 89 to 99 %, 95 % on average.
struct FlightParams {
  std::uint64_t seed = 1;  ///< another seed is another wind, swing and sensor noise
  std::string kind = "balloon";
  int frames = 70;  ///< instants at which the camera may take one; a gap leaves some out
  double interval_s = 2;
  CameraModel camera = default_camera();

  double altitude_m = 100;             ///< of the gondola at rest, above the level z = 0
  double altitude_oscillation = 0.03;  ///< amplitude, share of the altitude
  double altitude_period_s = 200;
  double drift_m_s = 2.5;
  double drift_heading_rad = 0;  ///< from x towards y
  double meander_m = 6;          ///< amplitude across the drift
  double meander_period_s = 240;

  double gust_m_s = 0.07;  ///< standard deviation of the wind's speed, along the drift and across it
  double gust_time_s = 20;
  double balloon_lag_s = 5;  ///< time constant with which the balloon takes on the wind's speed

  double suspension_m = 15;    ///< from the balloon's suspension point to the camera
  double gravity_m_s2 = 3.73;  ///< Mars; period of the swing 2 pi sqrt(suspension / gravity)
  double swing_rad = 0.018;    ///< amplitude at the beginning in the plane of the drift; across it half of it
  double swing_damping = 0.03;
  double yaw_rad = 0.2;  ///< amplitude; at rest the image's x axis points along the drift
  double yaw_period_s = 280;
  double yaw_rate_rad_s = 0;

  double off_nadir_rad = 0;          ///< of the optical axis when the gondola hangs still
  double off_nadir_azimuth_rad = 0;  ///< from the image's x axis at rest, counterclockwise seen from above
  double descent_m_s = 0.5;
  double descent_ratio = 0;  ///< first height over last height, above z = 0; 0: at constant speed
  double descent_drift = 0;  ///< with a descent_ratio: metres along drift_heading_rad for each metre down

  double gap_start_s = 0;
  double gap_length_s = 0;

  std::string pattern = "straight";
  double pattern_length_m = 300;
  double pattern_width_m = 120;
  double pattern_turn_radius_m = 25;  ///< of lawn-mower, rectangle and rosette
  double side_overlap = 0.3;    ///< of neighbouring legs of a lawn-mower, share of the image's width on the ground
  bool turn_with_track = true;  ///< the camera keeps its angle to the pattern; else it keeps its heading
  double start_x_m = 0;
  double start_y_m = 0;

  int passes = 1;
  double pass_pause_s = 40;         ///< from the end of a pass to the next, without frames
  double pass_altitude = 1;         ///< of a pass over that of the pass before
  double pass_heading_rad = 0;      ///< by which each pass is turned against the one before, about the middle of both
  double pass_yaw_rad = 0;          ///< by which the camera is turned in addition
  double pass_sun_azimuth_rad = 0;  ///< by which the sun is further in each pass

  double revisit = 0;  ///< share of the flight after which it turns back; 0: never
  double revisit_turn_s = 40;
  double revisit_offset_m = 0;  ///< of the way back from the way out, to the left
  double revisit_yaw_rad = 0;   ///< by which the turn turns the camera

  bool altimeter = false;
};

/// All but the camera.
[[nodiscard]] std::vector<Parameter> parameters(FlightParams& flight);
/// A negative cx or cy stands for the image's centre until `centred`.
[[nodiscard]] std::vector<Parameter> parameters(CameraModel& camera);
[[nodiscard]] CameraModel centred(CameraModel camera);

/// std::invalid_argument names the first field that is out of its range or contradicts another.
void validate(const FlightParams& flight);

/// Seconds from the first exposure to the last, pauses between passes included.
[[nodiscard]] double flight_length_s(const FlightParams& flight);

}  // namespace ilp::world
