#include "sim/lab/mission_input.hpp"

#include "bsp/flight/mission_file.hpp"
#include "sim/io/status_error.hpp"

namespace ilp::lab {

MissionParameters read_mission(const std::string& file) {
  MissionParameters mission;
  if (file.empty()) return mission;
  MissionFileError error;
  const Status status = read_mission_file(file.c_str(), mission, error);
  const std::string entry = error.key[0] == 0 ? "" : ", [" + std::string(error.section) + "] " + error.key;
  sim::require(status, "mission file " + file + entry);
  return mission;
}

}  // namespace ilp::lab
