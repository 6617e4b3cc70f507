// Localises the keyframes of a flight on a map after the flight, with the flight's own stage (fsw/localisation). This
// tests a map on images of a flight that did not carry it.
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
  MissionParameters mission;           ///< only the parameters of the map, the epoch and the body are used
  bool any_body = true;                ///< true: the map's body is used; false: it must be that of the mission
  std::vector<std::uint8_t> key = {};  ///< the map must be signed with this key; empty: no signature needed
};

struct MapCheck {
  Body body = Body::none;
  FixSummary in_flight;             ///< fixes of the flight, as downlinked
  FixSummary fixes;                 ///< fixes on the checked map
  std::vector<std::string> events;  ///< in words: missing tiles, and events of the stage
};

/// Runs the check with the downlinked poses, images, depths and measurements. Throws std::runtime_error if the map or
/// the flight cannot be used.
[[nodiscard]] MapCheck check_map(const MapCheckOptions& options, std::ostream& messages);

}  // namespace ilp::fixes
