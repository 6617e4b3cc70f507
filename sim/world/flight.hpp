// The track of a drifting, swinging balloon. World frame: metres, z up; camera: x right, y down, z forward.
#pragma once

#include <cstdint>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "sim/world/camera_state.hpp"

namespace ilp::sim {

/// 640x480, 60 degrees wide, no distortion.
[[nodiscard]] CameraModel default_camera();

/// Periods are long against the frame interval: with the defaults consecutive frames overlap by 93 to 97 %, 95 % on
/// average.
struct FlightParams {
  std::uint64_t seed = 1;  ///< another seed is another meander, swing and sensor noise
  int frames = 70;
  double interval_s = 2;
  CameraModel camera = default_camera();
  double noise_grey = 1;  ///< standard deviation of the sensor's noise, grey levels

  double altitude_m = 100;             ///< of the gondola at rest, above the level z = 0
  double altitude_oscillation = 0.03;  ///< amplitude, share of the altitude
  double altitude_period_s = 200;
  double drift_m_s = 2.5;
  double drift_heading_rad = 0;  ///< from x towards y
  double meander_m = 6;          ///< amplitude across the drift
  double meander_period_s = 240;
  double swing_rad = 0.044;  ///< amplitude in the plane of the drift; across it half of it
  double swing_period_s = 70;
  double suspension_m = 15;  ///< centre of the swing above the camera
  double yaw_rad = 0.2;      ///< amplitude; at rest the image's x axis points along the drift
  double yaw_period_s = 280;
};

/// One state per frame, from time 0 on. std::invalid_argument names the field that is out of its range.
[[nodiscard]] std::vector<CameraState> fly(const FlightParams& params);

}  // namespace ilp::sim
