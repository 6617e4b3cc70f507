#include "fsw/downlink/map_uplink.hpp"

#include <cstring>

namespace ilp {
namespace {

bool ends_in(const char* name, const char* end) {
  const std::size_t size = std::strlen(name), length = std::strlen(end);
  return size > length && std::strcmp(name + size - length, end) == 0;
}

bool is_directory(const char* name) {
  return ends_in(name, ".ilpm");
}

MapTilePlace place_of(const MapTileEntry& entry) {
  return {entry.layer, entry.row, entry.column};
}

std::int64_t bytes_of_tiles(const MapDirectory& directory) {
  std::int64_t bytes = 0;
  for (const MapTileEntry& entry : directory.tiles) bytes += entry.bytes;
  return bytes;
}

/// The directory that lies in the folder.
Status read_present(MapFolder& folder, MapUplinkWorkspace& workspace) {
  std::size_t size = 0;
  ILP_TRY(folder.read_directory(workspace.file, size));
  return parse_map_directory(std::span(workspace.file).first(size), folder.key(), workspace.directory);
}

Status keep_directory(std::span<const std::uint8_t> file, MapFolder& folder, const MissionParameters& mission,
                      MapUplinkWorkspace& workspace, Status& updates) {
  const MapDirectory& directory = workspace.directory;
  ILP_TRY(parse_map_directory(file, folder.key(), workspace.directory));
  if (directory.body != mission.body) {
    return {StatusCode::map_other_body, static_cast<std::int64_t>(directory.body),
            static_cast<std::int64_t>(mission.body)};
  }
  const std::int64_t bytes = bytes_of_tiles(directory) + static_cast<std::int64_t>(file.size());
  const double allowed = limits::map_share * static_cast<double>(mission.storage_budget_mib) * (1U << 20U);
  if (static_cast<double>(bytes) > allowed)
    return {StatusCode::capacity_exceeded, bytes, static_cast<std::int64_t>(allowed)};
  updates = {StatusCode::map_received, static_cast<std::int64_t>(directory.tiles.size()), bytes};
  const std::uint64_t id = directory.id;
  const bool replaces = read_present(folder, workspace).ok() && directory.id != id;
  ILP_TRY(folder.write_directory(file));
  if (!replaces) return {};
  // One that stays is a hole of the new map.
  for (const MapTileEntry& entry : directory.tiles) static_cast<void>(folder.erase_tile(place_of(entry)));
  return {};
}

Status keep_tile(std::span<const std::uint8_t> file, MapFolder& folder, MapUplinkWorkspace& workspace) {
  ILP_TRY(read_present(folder, workspace));
  const std::uint64_t digest = map_tile_digest(workspace.directory.id, file);
  for (const MapTileEntry& entry : workspace.directory.tiles) {
    if (entry.digest == digest && entry.bytes == file.size()) return folder.write_tile(place_of(entry), file);
  }
  return StatusCode::record_damaged;
}

}  // namespace

bool is_map_file(const char* name) {
  return is_directory(name) || ends_in(name, ".ilpt");
}

Status keep_map_file(const char* name, std::span<const std::uint8_t> file, MapFolder* folder,
                     const MissionParameters& mission, MapUplinkWorkspace& workspace, Status& updates) {
  updates = {};
  if (folder == nullptr) return StatusCode::not_found;
  if (!is_directory(name)) return keep_tile(file, *folder, workspace);
  const Status status = keep_directory(file, *folder, mission, workspace, updates);
  if (!status.ok()) updates = {};
  return status;
}

}  // namespace ilp
