#include "sim/host/mission_input.hpp"

#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "bsp/flight/mission_file.hpp"
#include "sim/host/status_error.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::host {
namespace {

std::string fault_of_entry(const MissionEntry& entry) {
  const std::size_t index = find_parameter(entry.section, entry.key);
  if (index == parameter_count()) {
    return "no such parameter (docs/parameters.md lists them)" +
           did_you_mean(std::string(entry.section) + "." + entry.key, parameter_names());
  }
  const ParameterInfo& info = parameter_info(index);
  std::ostringstream text;
  if (!info.choices.empty()) {
    std::vector<std::string> names;
    text << "expected";
    for (const EnumValue& choice : info.choices) {
      text << (names.empty() ? " " : " or ") << choice.name;
      names.emplace_back(choice.name);
    }
    text << did_you_mean(entry.value, names);
    return text.str();
  }
  text << "not a number from " << info.minimum << " to " << info.maximum;
  if (*info.unit != 0) text << " " << info.unit;
  if (std::string(info.unit) == "rad") text << ", or degrees, written 20deg";
  text << " (docs/parameters.md)";
  return text.str();
}

}  // namespace

std::vector<std::string> parameter_names() {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < parameter_count(); ++i)
    names.push_back(std::string(parameter_info(i).section) + "." + parameter_info(i).key);
  return names;
}

MissionParameters read_mission(const std::string& file, MissionParameters mission) {
  if (file.empty()) return mission;
  MissionEntry entry;
  const Status status = read_mission_file(file.c_str(), mission, entry);
  if (status.ok()) return mission;
  std::string message = "mission file " + file + ": ";
  if (entry.key[0] != 0) {
    message += "[" + std::string(entry.section) + "] " + entry.key + " = " + entry.value + ": " + fault_of_entry(entry);
  } else {
    message += status.is(StatusCode::not_found) ? "there is no such file; check the path" : describe(status);
  }
  throw std::runtime_error(message);
}

}  // namespace ilp::host
