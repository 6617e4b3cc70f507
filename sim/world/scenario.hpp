// A scenario: a world, a flight over it, a camera and what goes wrong, by name or from a file.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sim/world/camera_effects.hpp"
#include "sim/world/flight_params.hpp"
#include "sim/world/given_camera.hpp"
#include "sim/world/parameter.hpp"
#include "sim/world/vehicle_sensors.hpp"
#include "sim/world/world_params.hpp"

namespace ilp::world {

// Scenario files as text: [section], name = value, and where each entry stands.

/// One line of a scenario file, or one --set.
struct ScenarioEntry {
  std::string section, name, value;
  std::string origin;  ///< file and line, for messages
};

/// "section.name=value". std::invalid_argument when it is not of this form.
[[nodiscard]] ScenarioEntry parse_override(const std::string& text);

/// An .ini file; ';' and '#' begin comments. std::invalid_argument names the file, and the line of what is no section
/// and no entry, of an entry given twice and of a line that is too long.
[[nodiscard]] std::vector<ScenarioEntry> read_scenario_file(const std::filesystem::path& path);

/// Whether an entry with this value is read as it was written.
[[nodiscard]] bool can_stand_in_a_file(const std::string& value);

struct Scenario {
  std::string name;
  WorldParams world;
  FlightParams flight;
  CameraEffects effects;
  GivenCameraErrors given;
  VehicleSensors navigation;
  std::string mission_file;           ///< parameters of the flight software; empty: its defaults
  std::vector<ScenarioEntry> faults;  ///< for the program that flies it, uninterpreted; each name once
};

/// A section of scenario files with its parameters.
struct ScenarioSection {
  std::string_view name;
  std::vector<Parameter> parameters;
};

/// [scenario], [world], [flight], [camera], [effects], [given], [navigation] and [mission], with the fields of this
/// scenario.
[[nodiscard]] std::vector<ScenarioSection> sections(Scenario& scenario);

inline constexpr std::string_view default_scenario = "mars-plains";

/// A sensor as flown: shot noise at a full well of 10000 electrons, 1 grey level of read noise, a point spread of
/// 0.6 px, vignetting of 0.2, and a gain that changes by up to a tenth between frames.
[[nodiscard]] CameraEffects realistic_effects();

/// A balloon over one of the preset worlds (world_preset), at an altitude and speed that suit it, consecutive
/// frames overlapping by about 95 %, with realistic effects and a lens that distorts a little. std::invalid_argument
/// lists the names there are.
[[nodiscard]] Scenario scenario_preset(std::string_view name);

/// The preset or the file of this name, then the overrides. `scenario.preset` (the base of everything else) and
/// `effects.set` (realistic or none) count before the other entries of the file, or of the overrides. Paths in a
/// scenario file are relative to it. World, flight, camera and effects come back complete and validated.
/// std::invalid_argument names file and line, section, parameter and what was expected.
[[nodiscard]] Scenario load_scenario(const std::string& name_or_file, const std::vector<ScenarioEntry>& overrides);

/// Every parameter with its unit and meaning: a file that load_scenario reads as the same scenario.
void write_scenario(const std::filesystem::path& path, const Scenario& scenario);

}  // namespace ilp::world
