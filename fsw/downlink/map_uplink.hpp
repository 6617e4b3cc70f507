// Files of a map from the ground: checked, and put into the map's folder (docs/map-relative.md).
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "cfg/mission.hpp"
#include "fsw/maps/map_directory.hpp"
#include "hal/maps/map_source.hpp"

namespace ilp {

struct MapUplinkWorkspace {
  MapDirectory directory;
  std::array<std::uint8_t, max_map_directory_bytes> file;
};

/// Whether a file of this name is one of a map: it ends in `.ilpm` (directory) or `.ilpt` (tile).
[[nodiscard]] bool is_map_file(const char* name);

/// Puts a whole file of a map where the map lies. `updates` is the event besides: `map_received`, or
/// nothing.
///
/// A directory must be as parse_map_directory wants it, signed if the folder has a key, of the mission's body, and its
/// files must take at most limits::map_share of the storage budget. The tiles of the map that it replaces are erased. A
/// tile must be one that the directory in the folder names, by its digest: a damaged or forged tile replaces none.
///
/// `not_found`: the flight has no folder for a map, or a tile comes before its directory; `record_damaged`: a tile that
/// the directory does not name; `map_other_body`, `capacity_exceeded` (needed and allowed bytes); the faults of
/// parse_map_directory and of the folder.
Status keep_map_file(const char* name, std::span<const std::uint8_t> file, MapFolder* folder,
                     const MissionParameters& mission, MapUplinkWorkspace& workspace, Status& updates);

}  // namespace ilp
