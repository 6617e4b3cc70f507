// Directories and tiles of maps that hold anything, with right checksums.
#include <algorithm>
#include <memory>
#include <vector>

#include "fsw/base/crc.hpp"
#include "fsw/base/little_endian.hpp"
#include "fsw/maps/map_tile.hpp"
#include "tests/fuzz/targets.hpp"

namespace ilp::fuzz {
namespace {

using Bytes = std::vector<std::uint8_t>;

bool is_of_a_map(const Status& status) {
  return status.is(StatusCode::parse_error) || status.is(StatusCode::truncated) ||
         status.is(StatusCode::unsupported_format);
}

void directory(Octets input) {
  static const auto parsed = std::make_unique<MapDirectory>();
  constexpr std::size_t end = 4 + 32;
  Bytes bytes(input.begin(), input.end());
  if (bytes.size() >= end) {
    const Octets content(bytes.data(), bytes.size() - end);
    store_little_endian(crc32(content), bytes.data() + content.size());
  }
  const Status status = parse_map_directory(bytes, {}, *parsed);
  if (!status.ok()) return require(is_of_a_map(status), "a reason of the page");
  for (std::size_t i = 0; i < parsed->tiles.size(); ++i) {
    const MapTileEntry& entry = parsed->tiles[i];
    require(find_map_tile(*parsed, entry.layer, entry.row, entry.column) == i, "every tile is found");
  }
  Bytes again(max_map_directory_bytes);
  std::size_t size = 0;
  require(write_map_directory(*parsed, {}, again, size).ok(), "what is read can be written");
  require(size == bytes.size() && std::equal(bytes.begin(), bytes.end() - 32, again.begin()), "the same again");
}

void tile(Octets input) {
  static const auto map = std::make_unique<MapDirectory>();
  static const auto workspace = std::make_unique<MapTileWorkspace>();
  static const auto decoded = std::make_unique<MapTile>();
  static MapTileFeatures features;
  map->layer_count = 1;
  map->tiles.clear();
  MapTileEntry entry{.bytes = static_cast<std::uint16_t>(input.size())};
  // The tile that the file says it is, of the map that it says it is of.
  if (input.size() >= 20) {
    entry.layer = load_little_endian<std::uint16_t>(input.data() + 6);
    entry.row = load_little_endian<std::uint16_t>(input.data() + 8);
    entry.column = load_little_endian<std::uint16_t>(input.data() + 10);
    map->id = load_little_endian<std::uint64_t>(input.data() + 12);
  }
  entry.digest = map_tile_digest(map->id, input);
  require(map->tiles.push_back(entry), "one tile");
  const Status status = decode_map_tile(input, *map, 0, *workspace, *decoded);
  require(status.ok() || is_of_a_map(status), "a reason of the page");
  const Status listed = read_map_features(input, *map, 0, features);
  require(listed.ok() || is_of_a_map(listed), "a reason of the page");
  if (!listed.ok()) return;
  for (const PlaceFeature& feature : features.image) {
    require(feature.x >= -0.5F && feature.x < map_tile_side - 0.5F && feature.level < place_levels, "inside the tile");
  }
}

}  // namespace

void map_files(Octets input) {
  if (input.empty()) return;
  const Octets rest = input.subspan(1);
  input[0] % 2 == 0 ? directory(rest) : tile(rest);
}

}  // namespace ilp::fuzz
