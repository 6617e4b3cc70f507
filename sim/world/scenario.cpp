#include "sim/world/scenario.hpp"
#include "sim/host/files.hpp"

#include <ini.h>
#include <cerrno>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <stdexcept>

#include "cfg/mission.hpp"
#include "sim/host/text_format.hpp"
#include "sim/world/world_params.hpp"

namespace ilp::world {
namespace fs = std::filesystem;
namespace {

/// At the surface of the body that a preset's name begins with, or else of Mars; m/s^2.
double gravity_at(std::string_view preset) {
  if (preset.starts_with("titan")) return 1.352;
  if (preset.starts_with("venus")) return 8.87;
  if (preset.starts_with("earth") || preset.starts_with("testbed")) return 9.81;
  return 3.71;
}

/// The body whose name a preset's begins with; the testbed is on Earth.
std::string body_at(std::string_view preset) {
  if (preset.starts_with("testbed")) return "earth";
  for (const EnumValue& body : values_of(Body{})) {
    if (body.number != 0 && preset.starts_with(body.name)) return body.name;
  }
  return "";
}

/// The default flight, all lengths in proportion to the altitude and all slow motions to the interval. The suspension
/// is as long as it is, or shorter where the flight is low.
FlightParams flight_over(const WorldPreset& preset) {
  FlightParams flight;
  const FlightParams model;
  const double size = preset.altitude_m / model.altitude_m;
  flight.altitude_m = preset.altitude_m;
  flight.drift_m_s = preset.drift_m_s;
  flight.interval_s = model.interval_s * size * model.drift_m_s / preset.drift_m_s;
  const double pace = flight.interval_s / model.interval_s;
  for (double* length :
       {&flight.meander_m, &flight.pattern_length_m, &flight.pattern_width_m, &flight.pattern_turn_radius_m}) {
    *length *= size;
  }
  flight.gust_m_s *= size / pace;
  flight.descent_m_s *= size / pace;
  for (double* period : {&flight.altitude_period_s, &flight.meander_period_s, &flight.gust_time_s, &flight.yaw_period_s,
                         &flight.revisit_turn_s, &flight.pass_pause_s}) {
    *period *= pace;
  }
  flight.suspension_m *= std::min(1.0, size);
  flight.gravity_m_s2 = gravity_at(preset.name);
  return flight;
}

std::vector<std::string> preset_list() {
  std::vector<std::string> names;
  for (const WorldPreset& preset : world_presets()) names.emplace_back(preset.name);
  return names;
}

std::string preset_names() {
  std::string names;
  for (const WorldPreset& preset : world_presets()) names += (names.empty() ? "" : ", ") + std::string(preset.name);
  return names;
}

const WorldPreset* find_preset(std::string_view name) {
  for (const WorldPreset& preset : world_presets()) {
    if (preset.name == name) return &preset;
  }
  return nullptr;
}

[[noreturn]] void refuse(const ScenarioEntry& entry, const std::string& message) {
  throw std::invalid_argument(entry.origin + ": " + message);
}

const ScenarioEntry* find_entry(const std::vector<ScenarioEntry>& entries, std::string_view section,
                                std::string_view name) {
  const ScenarioEntry* found = nullptr;
  for (const ScenarioEntry& entry : entries) {
    if (entry.section == section && entry.name == name) found = &entry;
  }
  return found;
}

/// Of a name that the simulator does not have and the flight software has.
std::string place_of(const ScenarioEntry& entry) {
  if (find_parameter(entry.section.c_str(), entry.name.c_str()) == parameter_count()) return {};
  return "; it is a parameter of the flight software, which a file of --mission sets";
}

void apply_entry(const std::vector<ScenarioSection>& all, const ScenarioEntry& entry) {
  std::string known;
  std::vector<std::string> names = {"faults"};
  for (const ScenarioSection& section : all) {
    known += std::string(section.name) + ", ";
    names.emplace_back(section.name);
    if (section.name != entry.section) continue;
    try {
      set_parameter(section.parameters, entry.section, entry.name, entry.value);
    } catch (const std::invalid_argument& error) {
      refuse(entry, error.what() + place_of(entry));
    }
    return;
  }
  refuse(entry, "[" + entry.section + "]: no such section; there are " + known + "faults" +
                    host::did_you_mean(entry.section, names) + place_of(entry));
}

void apply_fault(std::vector<ScenarioEntry>& faults, const ScenarioEntry& entry) {
  std::erase_if(faults, [&](const ScenarioEntry& other) { return other.name == entry.name; });
  faults.push_back(entry);
}

/// The entries of one file, or all overrides.
void apply(const std::vector<ScenarioEntry>& entries, const fs::path& folder, Scenario& scenario) {
  if (const ScenarioEntry* const set = find_entry(entries, "effects", "set")) {
    if (set->value != "realistic" && set->value != "none")
      refuse(*set, "[effects] set = " + set->value + ": expected realistic or none");
    scenario.effects = set->value == "none" ? CameraEffects{} : realistic_effects();
  }
  const std::vector<ScenarioSection> all = sections(scenario);
  for (const ScenarioEntry& entry : entries) {
    if (entry.section == "faults") {
      apply_fault(scenario.faults, entry);
      continue;
    }
    if ((entry.section == "scenario" && entry.name == "preset") || (entry.section == "effects" && entry.name == "set"))
      continue;
    const bool path = (entry.section == "mission" && entry.name == "file") ||
                      (entry.section == "world" && (entry.name == "heightmap" || entry.name == "albedo_map"));
    ScenarioEntry placed = entry;
    if (path && !entry.value.empty()) placed.value = fs::absolute(folder / entry.value).lexically_normal().string();
    apply_entry(all, placed);
  }
}

Scenario base_for(const std::vector<ScenarioEntry>& overrides, const std::vector<ScenarioEntry>& file,
                  std::string_view otherwise) {
  const ScenarioEntry* chosen = find_entry(overrides, "scenario", "preset");
  if (chosen == nullptr) chosen = find_entry(file, "scenario", "preset");
  if (chosen == nullptr) return scenario_preset(otherwise);
  if (find_preset(chosen->value) == nullptr)
    refuse(*chosen, "[scenario] preset = " + chosen->value + ": expected one of " + preset_names());
  return scenario_preset(chosen->value);
}

/// The parameter's meaning, unit and range on one line.
std::string comment_on(const Parameter& parameter) {
  std::string text = "; " + std::string(parameter.meaning);
  const std::string range = range_text(parameter);
  if (!range.empty()) text += (parameter.meaning.empty() ? "" : ";") + range;
  return text == "; " ? std::string() : text + "\n";
}

constexpr std::size_t longest_line = 190;  // the parser cuts at 200
constexpr std::size_t longest_name = 49;   // the parser cuts section and name here

struct Reading {
  std::ifstream in;
  std::string file;
  int line = 0;
  std::string fault;
  std::vector<ScenarioEntry> entries;
};

std::string place(const Reading& reading, int line) {
  return reading.file + ", line " + std::to_string(line);
}

/// The parser's fgets: counts the lines, which the parser does not hand on.
char* next_line(char* buffer, int size, void* stream) {
  auto& reading = *static_cast<Reading*>(stream);
  std::string text;
  if (!reading.fault.empty() || !std::getline(reading.in, text)) return nullptr;
  ++reading.line;
  if (text.size() > longest_line || text.size() + 2 > static_cast<std::size_t>(size)) {
    reading.fault = place(reading, reading.line) + ": expected at most " + std::to_string(longest_line) + " characters";
    return nullptr;
  }
  if (text.find('\0') != std::string::npos) {
    reading.fault = place(reading, reading.line) + ": expected text";
    return nullptr;
  }
  // An indented line would continue the value before it.
  text.erase(0, text.find_first_not_of(" \t"));
  text += '\n';
  std::memcpy(buffer, text.c_str(), text.size() + 1);
  return buffer;
}

int take_entry(void* user, const char* section, const char* name, const char* value) {
  auto& reading = *static_cast<Reading*>(user);
  if (!reading.fault.empty()) return 1;
  const std::string full = "[" + std::string(section) + "] " + name;
  for (const ScenarioEntry& entry : reading.entries) {
    if (entry.section == section && entry.name == name)
      reading.fault = place(reading, reading.line) + ": " + full + " is given a second time, expected once";
  }
  if (std::strlen(section) >= longest_name || std::strlen(name) >= longest_name)
    reading.fault = place(reading, reading.line) + ": " + full + "...: there is no name as long as this";
  reading.entries.push_back({section, name, value, place(reading, reading.line)});
  return 1;
}

}  // namespace

std::vector<ScenarioSection> sections(Scenario& s) {
  return {{"scenario", {{"name", &s.name, "", "name of the scenario, for readers"}}},
          {"world", parameters(s.world)},
          {"flight", parameters(s.flight)},
          {"camera", parameters(s.flight.camera)},
          {"effects", parameters(s.effects)},
          {"given", parameters(s.given)},
          {"navigation", parameters(s.navigation)},
          {"mission",
           {{"file", &s.mission_file, "",
             "mission file with the parameters of the flight software; empty: the defaults"}}}};
}

CameraEffects realistic_effects() {
  CameraEffects effects;
  effects.vignetting = 0.2;
  effects.psf_sigma_px = 0.6;
  effects.gain_step = 0.1;
  effects.full_well_e = 10000;
  effects.shot_noise = true;
  effects.read_noise_grey = 1;
  return effects;
}

Scenario scenario_preset(std::string_view name) {
  const WorldPreset* const preset = find_preset(name);
  if (preset == nullptr)
    throw std::invalid_argument("scenario " + std::string(name) + ": expected a file or one of " + preset_names() +
                                host::did_you_mean(std::string(name), preset_list()));
  Scenario scenario;
  scenario.name = preset->name;
  scenario.world = preset->world;
  scenario.flight = flight_over(*preset);
  scenario.flight.camera.k1 = -0.08;
  scenario.flight.camera.k2 = 0.01;
  scenario.flight.camera.p1 = 0.0004;
  scenario.flight.camera.p2 = -0.0003;
  scenario.effects = realistic_effects();
  scenario.navigation.body = body_at(preset->name);
  return scenario;
}

Scenario load_scenario(const std::string& name_or_file, const std::vector<ScenarioEntry>& overrides) {
  const bool is_file = find_preset(name_or_file) == nullptr && fs::exists(name_or_file);
  const fs::path path = name_or_file;
  std::vector<ScenarioEntry> entries;
  if (is_file) entries = read_scenario_file(path);
  Scenario scenario = base_for(overrides, entries, is_file ? default_scenario : name_or_file);
  if (is_file) scenario.name = path.stem().string();
  scenario.flight.camera.cx = scenario.flight.camera.cy = -1;
  apply(entries, path.parent_path(), scenario);
  apply(overrides, {}, scenario);
  scenario.flight.camera = centred(scenario.flight.camera);
  try {
    validate(scenario.world);
    validate(scenario.flight);
    check_parameters(parameters(scenario.effects), "effects");
    check_parameters(parameters(scenario.given), "given");
    check_parameters(parameters(scenario.navigation), "navigation");
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("scenario " + name_or_file + ": " + error.what());
  }
  return scenario;
}

void write_scenario(const fs::path& path, const Scenario& scenario) {
  Scenario copy = scenario;
  std::ofstream out(path, std::ios::binary);
  out << "; A scenario of the aerobot ILP simulator, complete.\n";
  const auto write = [&](std::string_view section, std::string_view name, const std::string& value) {
    if (!can_stand_in_a_file(value)) {
      throw std::invalid_argument("[" + std::string(section) + "] " + std::string(name) + " = " + value +
                                  ": too long for a scenario file, or with spaces or ';' that it would lose");
    }
    out << name << (value.empty() ? " =" : " = ") << value << "\n";
  };
  for (const ScenarioSection& section : sections(copy)) {
    out << "\n[" << section.name << "]\n";
    for (const Parameter& parameter : section.parameters) {
      out << comment_on(parameter);
      write(section.name, parameter.name, parameter_text(parameter));
    }
  }
  if (!scenario.faults.empty()) out << "\n[faults]\n";
  for (const ScenarioEntry& fault : scenario.faults) write("faults", fault.name, fault.value);
  if (!out.flush()) throw std::runtime_error(path.string() + ": cannot be written: " + host::write_failure(errno));
}

ScenarioEntry parse_override(const std::string& text) {
  const std::size_t equals = text.find('=');
  const std::size_t dot = text.find('.');
  if (equals == std::string::npos || dot == std::string::npos || dot == 0 || dot + 1 >= equals) {
    throw std::invalid_argument("--set " + text + ": expected section.name=value, such as flight.altitude_m=120");
  }
  return {text.substr(0, dot), text.substr(dot + 1, equals - dot - 1), text.substr(equals + 1), "--set"};
}

std::vector<ScenarioEntry> read_scenario_file(const fs::path& path) {
  Reading reading;
  reading.file = path.string();
  std::error_code ignored;
  if (fs::is_regular_file(path, ignored)) reading.in.open(path, std::ios::binary);
  if (!reading.in.is_open()) throw std::invalid_argument("scenario file " + path.string() + " cannot be read");
  const int result = ini_parse_stream(next_line, &reading, take_entry, &reading);
  if (result > 0 && (reading.fault.empty() || result < reading.line))
    throw std::invalid_argument(place(reading, result) + ": expected [section], name = value or a ; comment");
  if (!reading.fault.empty()) throw std::invalid_argument(reading.fault);
  return std::move(reading.entries);
}

bool can_stand_in_a_file(const std::string& value) {
  constexpr std::size_t longest_value = longest_line - longest_name - 3;
  const bool trimmed =
      value.empty() || (std::strchr(" \t", value.front()) == nullptr && std::strchr(" \t", value.back()) == nullptr);
  const bool comment = value.find(" ;") != std::string::npos || value.find("\t;") != std::string::npos ||
                       (!value.empty() && value.front() == ';');
  return trimmed && !comment && value.size() <= longest_value && value.find_first_of("\r\n") == std::string::npos;
}

}  // namespace ilp::world
