// Calm air and a slow swing of 70 s: what is tested over it does not hang on how a gust moves the keyframes.
#pragma once

#include <cmath>
#include <numbers>

#include "sim/world/scenario.hpp"

namespace ilp::test {

/// An image every 4 s; the principal point is in the middle of the image.
inline world::Scenario calm_scenario(int frames, int width, int height, double focal_px) {
  world::Scenario scenario;
  scenario.effects.read_noise_grey = 1;
  world::FlightParams& flight = scenario.flight;
  flight.frames = frames;
  flight.interval_s = 4;
  flight.gust_m_s = 0;
  flight.swing_damping = 0;
  flight.swing_rad = 0.044;
  flight.gravity_m_s2 = flight.suspension_m * std::pow(2 * std::numbers::pi / 70, 2);
  flight.camera.width = width;
  flight.camera.height = height;
  flight.camera.fx = flight.camera.fy = focal_px;
  flight.camera.cx = (width - 1) / 2.0;
  flight.camera.cy = (height - 1) / 2.0;
  return scenario;
}

}  // namespace ilp::test
