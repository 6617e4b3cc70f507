// One flight of the flight software, in virtual time or in real time.
#pragma once

#include <cstdint>
#include <ostream>
#include <string>

#include "cfg/mission.hpp"
#include "sim/sil/fault_plan.hpp"
#include "sim/sil/image_source.hpp"

namespace ilp::sil {

/// Gives SQLite its arena, as on board. Call it once, before anything in the process uses SQLite: GDAL, which reads
/// imported terrain, looks coordinate systems up with it. std::runtime_error when it comes too late.
void configure_store_memory();

struct FlightOptions {
  std::string out;
  std::string mission_file;
  std::string telecommands;  ///< file, may be empty
  std::string map;           ///< folder, may be empty
  std::uint64_t seed = 1;
  std::int64_t power_cut_after = 0;  ///< minor frames; 0: never
  bool resume = false;
  bool real_time = false;  ///< until SIGTERM or SIGINT when there is a packet link
  std::string link_udp, link_udp_peer, link_tcp, cfdp_udp, cfdp_udp_peer;  ///< ADDRESS:PORT, empty for none
  std::string key_file;
  FaultPlan faults;

  [[nodiscard]] bool linked() const { return !link_udp.empty() || !link_tcp.empty() || !cfdp_udp.empty(); }
};

/// The mission of the file, or the given one where it says nothing. std::runtime_error names what is wrong in the file.
MissionParameters load_mission(const FlightOptions& options, MissionParameters mission);

/// Of the program, after a flight whose keyframes have no pose.
inline constexpr int status_without_poses = 3;
/// Of a flight whose images broke off: what came until then has flown.
inline constexpr int status_broken_stream = 4;
/// Leaves flight.db, outbox/ and flight-info.json in the folder. The exit status of the program.
int fly(const FlightOptions& options, const MissionParameters& mission, ImageSource& source);

void print_memory_map(std::ostream& out);

}  // namespace ilp::sil
