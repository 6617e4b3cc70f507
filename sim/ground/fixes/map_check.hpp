// Localises the keyframes of a flight on a map after the flight, by the flight's own stage (fsw/localisation): so that
// a map can be tried on images that were taken without it.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "cfg/mission.hpp"
#include "fsw/maps/map_directory.hpp"
#include "sim/ground/fixes/fix_summary.hpp"

namespace ilp::fixes {

struct MapCheckOptions {
  std::filesystem::path outbox, map;
  MissionParameters mission;           ///< of which the map's parameters and the epoch are used
  bool any_body = true;                ///< the body of the mission is that of the map; false: they must agree
  std::vector<std::uint8_t> key = {};  ///< with which the map must be signed; empty: it need not be
};

struct MapCheck {
  Body body = Body::none;
  FixSummary in_flight;             ///< what came down
  FixSummary fixes;                 ///< what the map says now
  std::vector<std::string> events;  ///< tiles that are not there, and events of the stage, in words
};

/// Uses the poses, images, depths and measurements that came down. Throws std::runtime_error where there is no map that
/// can be used, or nothing of a flight.
[[nodiscard]] MapCheck check_map(const MapCheckOptions& options, std::ostream& messages);

}  // namespace ilp::fixes
