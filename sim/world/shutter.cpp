#include "sim/world/shutter.hpp"

#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp::world {

CameraState state_after(const CameraMotion& motion, double seconds) {
  CameraState state = motion.state;
  state.centre += seconds * motion.velocity_m_s;
  state.rotation = rotation_from_vector(seconds * motion.turn_rad_s) * motion.state.rotation;
  return state;
}

double row_time_s(const CameraEffects& effects, std::int32_t row, std::int32_t rows) {
  return effects.readout_s * (row / static_cast<double>(rows - 1) - 0.5);
}

}  // namespace ilp::world
