// Simulates the sensors of the vehicle that carries the camera: altimeter, attitude, satellite navigation, velocity.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cfg/choices.hpp"
#include "sim/world/flight.hpp"
#include "sim/world/parameter.hpp"
#include "sim/world/terrain.hpp"

namespace ilp::world {

/// All sensors measure at the same rate. The sigmas that they report are those of their noise; they do not report drift
/// and outliers.
struct VehicleSensors {
  bool altimeter = false;
  double height_noise = 0.01;  ///< one sigma, share of the height
  double height_outliers = 0;  ///< share of samples with a wrong height
  bool attitude = false;
  double tilt_noise_rad = 0.0087;     ///< one sigma of each sample
  double heading_noise_rad = 0.0087;  ///< one sigma of each sample; 0: the sensor does not know north
  double attitude_drift_rad = 0;      ///< amplitude of a tilt error with periods of 700 and 900 s
  bool position = false;
  double horizontal_noise_m = 2;  ///< one sigma per axis, correlated over 30 s
  double vertical_noise_m = 3;    ///< likewise
  bool velocity = false;
  double velocity_noise_m_s = 0.1;  ///< one sigma per axis
  double rate_hz = 10;
  double begin_s = 0, end_s = 1e9;                                     ///< first and last time of measurements
  double outage_begin_s = 0, outage_length_s = 0;                      ///< no measurements in this window
  std::string body;                                                    ///< empty: from the scenario's name, or Mars
  double longitude_deg = 137.4, latitude_deg = -4.6, elevation_m = 0;  ///< of the world's origin

  [[nodiscard]] bool any() const { return altimeter || attitude || position || velocity; }
};
[[nodiscard]] std::vector<Parameter> parameters(VehicleSensors& sensors);

/// The body that `body` names; Mars if it names none.
[[nodiscard]] Body body_of(const VehicleSensors& sensors);

/// The samples of a flight as the text of a file for NavigationFile (hal/navigation/csv).
[[nodiscard]] std::string navigation_text(const VehicleSensors& sensors, const Terrain& terrain,
                                          const Trajectory& trajectory, std::uint64_t seed);

}  // namespace ilp::world
