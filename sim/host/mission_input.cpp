#include "sim/host/mission_input.hpp"

#include <stdexcept>
#include <string>
#include <vector>

#include "bsp/flight/mission_file.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::host {
std::string unknown_parameter(const std::string& key) {
  MissionEntry entry;
  copy_text(entry.key, key.c_str());
  return fault_of_entry(entry).c_str();
}

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
    message += "[" + std::string(entry.section) + "] " + entry.key + " = " + entry.value + ": " +
               fault_of_entry(entry).c_str();
  } else {
    message += status.is(StatusCode::not_found) ? "there is no such file; check the path" : describe(status);
  }
  throw std::runtime_error(message);
}

}  // namespace ilp::host
