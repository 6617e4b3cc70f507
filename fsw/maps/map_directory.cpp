#include "fsw/maps/map_directory.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "fsw/base/crc.hpp"
#include "fsw/base/math.hpp"
#include "fsw/maps/byte_fields.hpp"
#include "fsw/packets/hmac_sha256.hpp"
#include "fsw/shared/body_figure.hpp"

namespace ilp {
namespace {

using map_file::fault_at;
using map_file::FieldReader;
using map_file::FieldWriter;

constexpr std::uint32_t directory_magic = 0x4D504C49;  // "ILPM"
constexpr std::uint16_t directory_version = 1;
constexpr std::size_t crc_bytes = 4, code_bytes = sizeof(HmacSha256);

/// Every field but those at the ends. Reading and writing name them once.
template <typename Directory, typename Field>
void each_directory_field(Directory& directory, Field field) {
  field(directory.id);
  for (auto* angle :
       {&directory.longitude_rad, &directory.latitude_rad, &directory.sun_azimuth_rad, &directory.sun_elevation_rad,
        &directory.ambient, &directory.image_sigma, &directory.height_sigma_m, &directory.place_sigma_m}) {
    field(*angle);
  }
  field(directory.layer_count);
  for (auto& layer : directory.layers) {
    field(layer.pixel_m);
    field(layer.x0_m);
    field(layer.y0_m);
    field(layer.columns);
    field(layer.rows);
  }
}

bool within(double value, double least, double most) {
  return std::isfinite(value) && value >= least && value <= most;
}

/// From the origin, which lies on the body: the way to its other side, and the rest of a tile.
double farthest_m(Body body, double tile_m) {
  constexpr double without_body = 1e8;
  const double radius = body_radii(body).equatorial_m;
  return radius > 0 ? pi * radius + tile_m : without_body;
}

bool is_valid(const MapLayer& layer, Body body) {
  if (!within(layer.pixel_m, 1e-3, 1e5) || layer.columns <= 0 || layer.columns > max_map_layer_side ||
      layer.rows <= 0 || layer.rows > max_map_layer_side) {
    return false;
  }
  const double tile = layer.pixel_m * map_tile_side, most = farthest_m(body, tile);
  return within(layer.x0_m, -most, most) && within(layer.y0_m, -most, most) &&
         within(layer.x0_m + layer.columns * tile, -most, most) && within(layer.y0_m - layer.rows * tile, -most, most);
}

bool facts_are_valid(const MapDirectory& d) {
  bool valid = within(d.longitude_rad, -2 * pi, 2 * pi) && within(d.latitude_rad, -pi / 2, pi / 2) &&
               within(d.sun_azimuth_rad, -2 * pi, 2 * pi) && within(d.sun_elevation_rad, 0, pi / 2) &&
               within(d.ambient, 0, 1) && within(d.image_sigma, 0, 255) && within(d.height_sigma_m, 0, 1e6) &&
               within(d.place_sigma_m, 0, 1e6) && d.layer_count > 0 && d.layer_count <= limits::max_map_layers;
  for (std::uint32_t i = 0; i < limits::max_map_layers && valid; ++i)
    valid = i >= d.layer_count || is_valid(d.layers[i], d.body);
  for (std::uint32_t i = 1; i < d.layer_count && valid; ++i) valid = d.layers[i].pixel_m > d.layers[i - 1].pixel_m;
  return valid;
}

std::tuple<std::uint16_t, std::uint16_t, std::uint16_t> order_of(const MapTileEntry& entry) {
  return {entry.layer, entry.row, entry.column};
}

bool is_valid(const MapDirectory& d, std::size_t at) {
  const MapTileEntry& entry = d.tiles[at];
  return entry.layer < d.layer_count && entry.row < d.layers[entry.layer].rows &&
         entry.column < d.layers[entry.layer].columns && entry.bytes > 0 &&
         (at == 0 || order_of(d.tiles[at - 1]) < order_of(entry));
}

HmacSha256 code_of(std::span<const std::uint8_t> key, std::span<const std::uint8_t> bytes) {
  const std::span<const std::uint8_t> parts[] = {bytes};
  return hmac_sha256(key, parts);
}

/// Checks what ends the directory, and returns what is before it.
Status open_directory(std::span<const std::uint8_t> bytes, std::span<const std::uint8_t> key,
                      std::span<const std::uint8_t>& content) {
  constexpr std::size_t end = crc_bytes + code_bytes;
  if (bytes.size() < end) return {StatusCode::truncated, static_cast<std::int64_t>(bytes.size()), end};
  content = bytes.first(bytes.size() - end);
  const std::size_t signed_bytes = content.size() + crc_bytes;
  if (crc32(content) != load_little_endian<std::uint32_t>(bytes.data() + content.size()))
    return fault_at(content.size());
  if (key.empty()) return {};
  const HmacSha256 code = code_of(key, bytes.first(signed_bytes));
  return equal_in_constant_time(code, bytes.subspan(signed_bytes)) ? Status{} : Status{StatusCode::map_not_authentic};
}

Status read_tiles(FieldReader& in, MapDirectory& directory) {
  std::uint32_t count = 0;
  in.read(count);
  if (!in.whole() || count > limits::max_map_tiles) return fault_at(in.at());
  for (std::uint32_t i = 0; i < count; ++i) {
    MapTileEntry entry;
    in.read(entry.digest);
    in.read(entry.bytes);
    in.read(entry.layer);
    in.read(entry.row);
    in.read(entry.column);
    if (!in.whole() || !directory.tiles.push_back(entry) || !is_valid(directory, i)) return fault_at(in.at());
  }
  return {};
}

}  // namespace

Status parse_map_directory(std::span<const std::uint8_t> bytes, std::span<const std::uint8_t> key,
                           MapDirectory& directory) {
  directory.tiles.clear();
  FieldReader head(bytes);
  std::uint32_t magic = 0;
  std::uint16_t version = 0;
  head.read(magic);
  head.read(version);
  if (!head.whole()) return {StatusCode::truncated, static_cast<std::int64_t>(bytes.size()), 6};
  if (magic != directory_magic) return fault_at(0);
  if (version != directory_version) return {StatusCode::unsupported_format, version};
  std::span<const std::uint8_t> content;
  ILP_TRY(open_directory(bytes, key, content));
  FieldReader in(content);
  std::uint8_t body = 0, light = 0;
  in.take(head.at());
  in.read(body);
  in.read(light);
  each_directory_field(directory, [&](auto& field) { in.read(field); });
  if (find_value(values_of(Body{}), body) == nullptr || find_value(values_of(MapLight{}), light) == nullptr) {
    return fault_at(head.at());
  }
  directory.body = static_cast<Body>(body);
  directory.light = static_cast<MapLight>(light);
  if (!in.whole() || !facts_are_valid(directory)) return fault_at(in.at());
  ILP_TRY(read_tiles(in, directory));
  return in.at() == content.size() ? Status{} : fault_at(in.at());
}

Status write_map_directory(const MapDirectory& directory, std::span<const std::uint8_t> key,
                           std::span<std::uint8_t> bytes, std::size_t& size) {
  size = 0;
  FieldWriter out(bytes);
  if (!facts_are_valid(directory)) return fault_at(0);
  out.write(directory_magic);
  out.write(directory_version);
  out.write(static_cast<std::uint8_t>(directory.body));
  out.write(static_cast<std::uint8_t>(directory.light));
  each_directory_field(directory, [&](const auto& field) { out.write(field); });
  out.write(static_cast<std::uint32_t>(directory.tiles.size()));
  for (std::size_t i = 0; i < directory.tiles.size(); ++i) {
    if (!is_valid(directory, i)) return fault_at(out.size());
    const MapTileEntry& entry = directory.tiles[i];
    out.write(entry.digest);
    out.write(entry.bytes);
    out.write(entry.layer);
    out.write(entry.row);
    out.write(entry.column);
  }
  const std::size_t whole = out.size() + crc_bytes + code_bytes;
  if (whole > bytes.size()) {
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(whole), static_cast<std::int64_t>(bytes.size())};
  }
  out.write(crc32(bytes.first(out.size())));
  const HmacSha256 code = key.empty() ? HmacSha256{} : code_of(key, bytes.first(out.size()));
  std::copy(code.begin(), code.end(), out.unused().begin());
  size = whole;
  return {};
}

std::size_t find_map_tile(const MapDirectory& directory, std::uint32_t layer, std::int32_t row, std::int32_t column) {
  const std::size_t none = directory.tiles.size();
  if (layer >= limits::max_map_layers || row < 0 || column < 0 || row >= max_map_layer_side ||
      column >= max_map_layer_side) {
    return none;
  }
  MapTileEntry wanted;
  wanted.layer = static_cast<std::uint16_t>(layer);
  wanted.row = static_cast<std::uint16_t>(row);
  wanted.column = static_cast<std::uint16_t>(column);
  const auto* const found =
      std::lower_bound(directory.tiles.begin(), directory.tiles.end(), wanted,
                       [](const MapTileEntry& a, const MapTileEntry& b) { return order_of(a) < order_of(b); });
  const auto at = static_cast<std::size_t>(found - directory.tiles.begin());
  return at < none && order_of(*found) == order_of(wanted) ? at : none;
}

std::uint64_t map_tile_digest(std::uint64_t map_id, std::span<const std::uint8_t> file) {
  std::array<std::uint8_t, sizeof(map_id)> key{};
  store_little_endian(map_id, key.data());
  return load_little_endian<std::uint64_t>(code_of(key, file).data());
}

bool is_map_tile(const MapDirectory& directory, const MapTileEntry& entry, std::span<const std::uint8_t> file) {
  return file.size() == entry.bytes && map_tile_digest(directory.id, file) == entry.digest;
}

}  // namespace ilp
