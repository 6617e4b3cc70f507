#include "sim/host/mission_input.hpp"

#include <stdexcept>
#include <string>
#include <vector>

#include "bsp/flight/mission_file.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::host {
namespace {

[[noreturn]] void refuse(const std::string& file, Status status, const MissionEntry& entry) {
  const auto fault = fault_of_mission(status, entry);
  throw std::runtime_error("mission file " + file + ": " + (fault.size() > 0 ? fault.c_str() : describe(status)));
}

}  // namespace

std::string unknown_parameter(const std::string& key) {
  MissionEntry entry;
  copy_text(entry.key, key.c_str());
  return fault_of_entry(entry).c_str();
}

std::string fault_of_value(const ParameterInfo& info, const std::string& value) {
  MissionEntry entry;
  copy_text(entry.section, info.section);
  copy_text(entry.key, info.key);
  copy_text(entry.value, value.c_str());
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
  if (!status.ok()) refuse(file, status, entry);
  return mission;
}

void check_mission_lines(const std::string& file) {
  MissionParameters mission;
  MissionEntry entry;
  const Status status = read_mission_file(file.c_str(), mission, entry);
  if (!status.ok() && !status.is(StatusCode::parameters_contradict)) refuse(file, status, entry);
}

}  // namespace ilp::host
