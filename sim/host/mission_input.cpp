#include "sim/host/mission_input.hpp"

#include <stdexcept>

#include "bsp/flight/mission_file.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::host {

MissionParameters read_mission(const std::string& file) {
  MissionParameters mission;
  if (file.empty()) return mission;
  MissionEntry error;
  const Status status = read_mission_file(file.c_str(), mission, error);
  const std::string entry = error.key[0] == 0 ? "" : ", [" + std::string(error.section) + "] " + error.key;
  if (status.is(StatusCode::not_found) && entry.empty())
    throw std::runtime_error("mission file " + file + ": there is no such file; check the path");
  require(status, "mission file " + file + entry);
  return mission;
}

}  // namespace ilp::host
