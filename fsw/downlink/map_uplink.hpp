// Checks uplinked files of a map and puts them into the map's folder (docs/map-relative.md).
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

/// Whether the name is that of a map's file: it ends in `.ilpm` (directory) or `.ilpt` (tile).
[[nodiscard]] bool is_map_file(const char* name);

/// Checks one complete file of a map and writes it to `folder`. `updates` becomes the event `map_received`, or ok.
///
/// A directory must be valid for parse_map_directory, signed if the folder has a key, and for the mission's body. Its
/// files must not exceed limits::map_share of the storage budget. The tiles of the map that it replaces are erased. A
/// tile must have a digest that the directory in the folder names, so that no damaged or forged tile is accepted.
///
/// Returns
/// - `not_found` if the flight has no folder for a map, or a tile comes before its directory;
/// - `record_damaged` for a tile that the directory does not name;
/// - `map_other_body`, or `capacity_exceeded` (values: needed and allowed bytes);
/// - the faults of parse_map_directory and of the folder.
Status keep_map_file(const char* name, std::span<const std::uint8_t> file, MapFolder* folder,
                     const MissionParameters& mission, MapUplinkWorkspace& workspace, Status& updates);

}  // namespace ilp
