// Makes the scenario that a command line asks for, and lists scenarios and parameters.
#pragma once

#include <cstdint>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "sim/sil/fault_plan.hpp"
#include "sim/world/scenario.hpp"

namespace ilp::sil {

struct ScenarioOptions {
  std::string scenario;               ///< preset or file; empty: the default scenario, or that of the resumed flight
  std::vector<std::string> set;       ///< values of --set: SECTION.NAME=VALUE
  std::optional<std::uint64_t> seed;  ///< of world, wind and sensor
  std::optional<int> frames;
};

/// Loads the scenario (`resumed_file` for a resumed flight) and applies seed, frames and then --set. Throws
/// std::invalid_argument that says what is wrong.
[[nodiscard]] world::Scenario chosen_scenario(const ScenarioOptions& options, const std::string& resumed_file);

/// The scenario for recorded images, whose options may set faults only. Throws host::WrongUsage for other options, and
/// std::invalid_argument for a malformed entry.
[[nodiscard]] world::Scenario faults_for_recorded_images(const ScenarioOptions& options);

/// Makes the plan from the scenario's entries in [faults]. Throws std::invalid_argument that names the origin of a
/// wrong entry, the parameter and what was expected.
[[nodiscard]] FaultPlan fault_plan(const world::Scenario& scenario);

void list_scenarios(std::ostream& out);
/// Lists every name that --set accepts, with its value in this scenario, unit, range and meaning.
void list_parameters(std::ostream& out, const world::Scenario& scenario);

}  // namespace ilp::sil
