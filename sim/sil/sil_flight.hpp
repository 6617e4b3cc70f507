// Runs one flight of the flight software, in virtual time or in real time.
#pragma once

#include <cstdint>
#include <ostream>
#include <string>

#include "cfg/mission.hpp"
#include "sim/sil/fault_plan.hpp"
#include "sim/sil/image_source.hpp"

namespace ilp::sil {

/// Gives SQLite its arena, as on board. Call this once, before any use of SQLite in the process; GDAL uses SQLite too,
/// for coordinate systems of imported terrain. Throws std::runtime_error if SQLite is already in use.
void configure_store_memory();

struct FlightOptions {
  std::string out;           ///< folder of the flight
  std::string mission_file;  ///< may be empty
  std::string telecommands;  ///< file, may be empty
  std::string map;           ///< folder, may be empty
  std::uint64_t seed = 1;
  std::int64_t power_cut_after = 0;  ///< minor frames; 0: never
  bool resume = false;
  bool real_time = false;  ///< with a packet link, until SIGTERM or SIGINT
  std::string link_udp, link_udp_peer, link_tcp, cfdp_udp, cfdp_udp_peer;  ///< ADDRESS:PORT; empty: none
  std::string key_file;
  FaultPlan faults;

  [[nodiscard]] bool linked() const { return !link_udp.empty() || !link_tcp.empty() || !cfdp_udp.empty(); }
};

/// `mission` with the values of the mission file, if one is named. Throws std::runtime_error that says what is wrong in
/// the file.
MissionParameters load_mission(const FlightOptions& options, MissionParameters mission);

/// Exit status of the program after a flight in which no keyframe has a pose.
inline constexpr int status_without_poses = 3;
/// Exit status after a flight whose images ended too early. The images up to then were flown.
inline constexpr int status_broken_stream = 4;
/// Flies, and leaves flight.db, outbox/ and flight-info.json in the folder. Returns the exit status of the program.
int fly(const FlightOptions& options, const MissionParameters& mission, ImageSource& source);

void print_memory_map(std::ostream& out);

}  // namespace ilp::sil
