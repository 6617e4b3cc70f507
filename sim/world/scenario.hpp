// A scenario: a world, a flight over it, a camera and faults. Loads it from a preset or a file, and writes it.
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

// The entries of scenario files: [section], name = value.

/// One line of a scenario file, or one --set.
struct ScenarioEntry {
  std::string section, name, value;
  std::string origin;  ///< file and line, for messages
};

/// Parses "section.name=value". Throws std::invalid_argument for another form.
[[nodiscard]] ScenarioEntry parse_override(const std::string& text);

/// Reads an .ini file; ';' and '#' begin comments. Throws std::invalid_argument that names the file, and the line if it
/// is neither a section nor an entry, repeats an entry or is too long.
[[nodiscard]] std::vector<ScenarioEntry> read_scenario_file(const std::filesystem::path& path);

/// Whether a file can hold this value so that it reads back unchanged.
[[nodiscard]] bool can_stand_in_a_file(const std::string& value);

struct Scenario {
  std::string name;
  WorldParams world;
  FlightParams flight;
  CameraEffects effects;
  GivenCameraErrors given;
  VehicleSensors navigation;
  std::string mission_file;           ///< mission file of the flight software; empty: default parameters
  std::vector<ScenarioEntry> faults;  ///< for the program that flies the scenario, not interpreted; each name once
};

/// A section of scenario files, with the fields that it sets.
struct ScenarioSection {
  std::string_view name;
  std::vector<Parameter> parameters;
};

/// The sections [scenario], [world], [flight], [camera], [effects], [given], [navigation] and [mission], which set the
/// fields of `scenario`.
[[nodiscard]] std::vector<ScenarioSection> sections(Scenario& scenario);

inline constexpr std::string_view default_scenario = "mars-plains";

/// Effects of a typical camera: shot noise with a full well of 10000 electrons, 1 grey level of read noise, a point
/// spread of 0.6 px, vignetting of 0.2, and a gain that changes by up to 10 % between frames.
[[nodiscard]] CameraEffects realistic_effects();

/// A balloon flight over a preset world (world_preset) at its altitude and speed, with an overlap of about 95 % between
/// consecutive frames, realistic effects and slight distortion. Throws std::invalid_argument with a list of the names
/// for an unknown name.
[[nodiscard]] Scenario scenario_preset(std::string_view name);

/// Loads the preset or the file with this name, and applies the overrides. In a file, and likewise in the overrides,
/// `scenario.preset` (the base of all other values) and `effects.set` (realistic or none) are applied before the other
/// entries. Paths in a scenario file are relative to the file. World, flight, camera and effects are complete and
/// valid. Throws std::invalid_argument that names file and line, section, parameter and what was expected.
[[nodiscard]] Scenario load_scenario(const std::string& name_or_file, const std::vector<ScenarioEntry>& overrides);

/// Writes every parameter with its unit and meaning, so that load_scenario reads the same scenario.
void write_scenario(const std::filesystem::path& path, const Scenario& scenario);

}  // namespace ilp::world
