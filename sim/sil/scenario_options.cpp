#include "sim/sil/scenario_options.hpp"

#include <iomanip>
#include <stdexcept>

#include "sim/host/wrong_usage.hpp"
#include "sim/world/world_params.hpp"

namespace ilp::sil {
namespace {

std::vector<world::ScenarioEntry> overrides(const ScenarioOptions& options) {
  std::vector<world::ScenarioEntry> entries;
  if (options.seed) {
    const std::string seed = std::to_string(*options.seed);
    entries.push_back({"world", "seed", seed, "--seed"});
    entries.push_back({"flight", "seed", seed, "--seed"});
  }
  if (options.frames) entries.push_back({"flight", "frames", std::to_string(*options.frames), "--frames"});
  for (const std::string& text : options.set) entries.push_back(world::parse_override(text));
  return entries;
}

void list(std::ostream& out, std::string_view section, const std::vector<world::Parameter>& parameters) {
  for (const world::Parameter& parameter : parameters) {
    const std::string name = std::string(section) + "." + std::string(parameter.name);
    out << std::left << std::setw(36) << name << std::setw(14) << world::parameter_text(parameter) << parameter.meaning;
    const std::string range = world::range_text(parameter);
    if (!range.empty()) out << (parameter.meaning.empty() ? "" : ";") << range;
    out << "\n";
  }
}

}  // namespace

world::Scenario chosen_scenario(const ScenarioOptions& options, const std::string& resumed_file) {
  std::string name = options.scenario;
  if (name.empty()) name = resumed_file.empty() ? std::string(world::default_scenario) : resumed_file;
  return world::load_scenario(name, overrides(options));
}

world::Scenario faults_for_recorded_images(const ScenarioOptions& options) {
  if (!options.scenario.empty())
    throw host::WrongUsage("--scenario " + options.scenario + ": expected no --images or --y4m beside it");
  world::Scenario scenario;
  for (const std::string& text : options.set) {
    const world::ScenarioEntry entry = world::parse_override(text);
    if (entry.section != "faults")
      throw host::WrongUsage("--set " + text + ": the images are recorded, expected faults.name=value only");
    scenario.faults.push_back(entry);
  }
  return scenario;
}

FaultPlan fault_plan(const world::Scenario& scenario) {
  FaultPlan plan;
  for (const world::ScenarioEntry& entry : scenario.faults) {
    try {
      world::set_parameter(parameters(plan), entry.section, entry.name, entry.value);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(entry.origin + ": " + error.what());
    }
  }
  return plan;
}

void list_scenarios(std::ostream& out) {
  for (const world::WorldPreset& preset : world::world_presets()) {
    out << std::left << std::setw(20) << preset.name << preset.meaning
        << (preset.name == world::default_scenario ? " (the default)" : "") << "\n";
  }
}

void list_parameters(std::ostream& out, const world::Scenario& scenario) {
  world::Scenario copy = scenario;
  out << "Values of the scenario " << scenario.name << ". Change them by --set NAME=VALUE or in a scenario file.\n\n"
      << std::left << std::setw(50) << "scenario.preset"
      << "the base of everything else; --list-scenarios names them\n"
      << std::setw(50) << "effects.set"
      << "all effects at once: realistic or none\n";
  for (const world::ScenarioSection& section : world::sections(copy)) list(out, section.name, section.parameters);
  FaultPlan plan = fault_plan(scenario);
  list(out, "faults", parameters(plan));
}

}  // namespace ilp::sil
