// One flight of the flight software in virtual time.
#pragma once

#include <cstdint>
#include <ostream>
#include <string>

#include "cfg/mission.hpp"
#include "sim/sil/fault_plan.hpp"
#include "sim/sil/image_source.hpp"

namespace ilp::sim {

struct FlightOptions {
  std::string out;
  std::string mission_file;
  std::string telecommands;  ///< file, may be empty
  std::uint64_t seed = 1;
  std::int64_t power_cut_after = 0;  ///< minor frames; 0: never
  bool resume = false;
  bool progress = false;
  FaultPlan faults;
};

/// The mission of the file, or the default one. std::runtime_error names what is wrong in the file.
MissionParameters load_mission(const FlightOptions& options);

/// Makes the folder ready: it must be new, empty, or hold an earlier flight when resuming. std::runtime_error
/// otherwise.
void prepare_folder(const FlightOptions& options);

/// Leaves flight.db, outbox/ and flight-info.json in the folder. The exit status of the program.
int fly(const FlightOptions& options, const MissionParameters& mission, ImageSource& source);

void print_memory_map(std::ostream& out);

}  // namespace ilp::sim
