// The sensors of the vehicle that carries the camera: altimeter, attitude, satellite navigation, velocity.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cfg/choices.hpp"
#include "sim/world/flight.hpp"
#include "sim/world/parameter.hpp"
#include "sim/world/terrain.hpp"

namespace ilp::world {

/// Each sensor measures at the same rate. What it states as its sigma is the noise that it has; drift and outliers are
/// not stated.
struct VehicleSensors {
  bool altimeter = false;
  double height_noise = 0.01;  ///< one sigma, share of the height
  double height_outliers = 0;  ///< share of the samples that measure something else
  bool attitude = false;
  double tilt_noise_rad = 0.0087;     ///< one sigma of each sample
  double heading_noise_rad = 0.0087;  ///< 0: the sensor does not know north
  double attitude_drift_rad = 0;      ///< amplitude of an error that changes over the flight
  bool position = false;
  double horizontal_noise_m = 2;  ///< one sigma, correlated over half a minute
  double vertical_noise_m = 3;
  bool velocity = false;
  double velocity_noise_m_s = 0.1;
  double rate_hz = 10;
  double begin_s = 0, end_s = 1e9;  ///< nothing is measured before and after
  double outage_begin_s = 0, outage_length_s = 0;
  std::string body;                                                    ///< empty: that of the scenario's name, or Mars
  double longitude_deg = 137.4, latitude_deg = -4.6, elevation_m = 0;  ///< of the world's origin

  [[nodiscard]] bool any() const { return altimeter || attitude || position || velocity; }
};
[[nodiscard]] std::vector<Parameter> parameters(VehicleSensors& sensors);

/// Where `body` names none: Mars.
[[nodiscard]] Body body_of(const VehicleSensors& sensors);

/// A file for NavigationFile (hal/navigation/csv) with the samples of a whole flight.
[[nodiscard]] std::string navigation_text(const VehicleSensors& sensors, const Terrain& terrain,
                                          const Trajectory& trajectory, std::uint64_t seed);

}  // namespace ilp::world
