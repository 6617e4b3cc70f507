// The scenario that a command line asks for, and what a person may choose from.
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
  std::string scenario;  ///< preset or file; empty: the default one, or that of the flight that is resumed
  std::vector<std::string> set;
  std::optional<std::uint64_t> seed;  ///< of world, wind and sensor
  std::optional<int> frames;
};

/// Seed and frames count before --set. std::invalid_argument says what is wrong.
[[nodiscard]] world::Scenario chosen_scenario(const ScenarioOptions& options, const std::string& resumed_file);

/// With recorded images only the faults can be chosen; std::invalid_argument for anything else.
[[nodiscard]] world::Scenario faults_for_recorded_images(const ScenarioOptions& options);

/// std::invalid_argument names where the entry stands, the parameter and what was expected.
[[nodiscard]] FaultPlan fault_plan(const world::Scenario& scenario);

void list_scenarios(std::ostream& out);
/// Every name that --set takes, with its value in this scenario, unit, range and meaning.
void list_parameters(std::ostream& out, const world::Scenario& scenario);

}  // namespace ilp::sil
