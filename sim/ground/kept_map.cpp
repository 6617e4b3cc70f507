#include "sim/ground/kept_map.hpp"

#include <gdal.h>
#include <zlib.h>

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include "sim/host/digest.hpp"
#include "sim/host/files.hpp"

namespace ilp::ground {
namespace {

using nlohmann::json;

template <typename T>
json packed(const host::Raster<T>& raster) {
  const auto* bytes = reinterpret_cast<const Bytef*>(raster.samples.data());
  const uLong plain = raster.samples.size() * sizeof(T);
  uLongf size = compressBound(plain);
  std::vector<std::uint8_t> packed(size);
  if (compress2(packed.data(), &size, bytes, plain, Z_BEST_SPEED) != Z_OK) throw std::runtime_error("no memory left");
  packed.resize(size);
  return json::binary(std::move(packed));
}

template <typename T>
void unpack(const json& packed, std::int32_t width, std::int32_t height, host::Raster<T>& raster) {
  const std::vector<std::uint8_t>& bytes = packed.get_binary();
  raster = host::Raster<T>(width, height);
  const uLong plain = raster.samples.size() * sizeof(T);
  uLongf size = plain;
  if (uncompress(reinterpret_cast<Bytef*>(raster.samples.data()), &size, bytes.data(), bytes.size()) != Z_OK ||
      size != plain) {
    throw std::runtime_error("a raster that is not whole");
  }
}

json as_json(const map::GroundGrid& grid) {
  return {{"x0", grid.x0},
          {"y0", grid.y0},
          {"cell", grid.cell},
          {"columns", grid.height.width},
          {"rows", grid.height.height},
          {"height", packed(grid.height)},
          {"sigma", packed(grid.sigma)},
          {"whole_sigma", packed(grid.whole_sigma)},
          {"ortho", packed(grid.ortho)},
          {"count", packed(grid.count)},
          {"source", packed(grid.source)},
          {"laid_height", packed(grid.laid.height)},
          {"laid_grey", packed(grid.laid.grey)}};
}

map::GroundGrid grid_from(const json& stored) {
  map::GroundGrid grid;
  const std::int32_t columns = stored.at("columns"), rows = stored.at("rows");
  if (columns <= 0 || rows <= 0) throw std::runtime_error("a grid without cells");
  grid.x0 = stored.at("x0");
  grid.y0 = stored.at("y0");
  grid.cell = stored.at("cell");
  unpack(stored.at("height"), columns, rows, grid.height);
  unpack(stored.at("sigma"), columns, rows, grid.sigma);
  unpack(stored.at("whole_sigma"), columns, rows, grid.whole_sigma);
  unpack(stored.at("ortho"), columns, rows, grid.ortho);
  unpack(stored.at("count"), columns, rows, grid.count);
  unpack(stored.at("source"), columns, rows, grid.source);
  unpack(stored.at("laid_height"), columns, rows, grid.laid.height);
  unpack(stored.at("laid_grey"), columns, rows, grid.laid.grey);
  return grid;
}

json as_json(const map::Roughness& r) {
  return {r.border_samples, r.other_samples, r.border, r.other};
}

map::Roughness roughness_from(const json& stored) {
  return {stored.at(0), stored.at(1), stored.at(2), stored.at(3)};
}

}  // namespace

std::uint64_t map_export_digest(std::uint64_t map, const exports::Georeference& place, const std::string& suffix,
                                std::size_t max_vertices) {
  static const std::uint64_t program = host::content_digest("/proc/self/exe").value_or(0);
  intake::InputDigest digest("map of a strip 3");
  digest.add_value(program).add_value(map).add_value(max_vertices);
  for (const std::string& text : {std::string(GDALVersionInfo("RELEASE_NAME")), place.crs, place.geographic, place.unit,
                                  place.height_name, place.sentence, place.body, suffix}) {
    digest.add_value(text.size()).add({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  }
  for (const double value : {place.longitude_deg, place.scale, place.sin_azimuth, place.cos_azimuth, place.anchored[0],
                             place.anchored[1], place.anchored[2], place.height}) {
    digest.add_value(value);
  }
  return digest.add_value(place.earth).value();
}

std::vector<std::uint8_t> bytes_of_map(const report::StripResult& strip, const std::set<std::uint64_t>& parts) {
  const map::MapGeometry& g = strip.geometry;
  return json::to_cbor(
      json{{"grid", as_json(*strip.grid)},
           {"plane", {strip.plane.a, strip.plane.b, strip.plane.c}},
           {"geometry", {g.x0, g.y0, g.cell, g.columns, g.rows}},
           {"seams", {as_json(strip.seams.height), as_json(strip.seams.grey), as_json(strip.seams.grey_step)}},
           {"parts", parts},
           {"files", strip.map_files},
           {"surface", {strip.vertices, strip.faces, strip.stride}}});
}

bool take_map(std::span<const std::uint8_t> bytes, report::StripResult& strip, std::set<std::uint64_t>& parts) {
  try {
    const json stored = json::from_cbor(bytes.begin(), bytes.end());
    report::StripResult taken = strip;
    taken.grid = grid_from(stored.at("grid"));
    const json &plane = stored.at("plane"), &geometry = stored.at("geometry"), &surface = stored.at("surface");
    taken.plane = {plane.at(0), plane.at(1), plane.at(2)};
    taken.geometry = {geometry.at(0), geometry.at(1), geometry.at(2), geometry.at(3), geometry.at(4)};
    const json& seams = stored.at("seams");
    taken.seams = {roughness_from(seams.at(0)), roughness_from(seams.at(1)), roughness_from(seams.at(2))};
    stored.at("files").get_to(taken.map_files);
    surface.at(0).get_to(taken.vertices);
    surface.at(1).get_to(taken.faces);
    surface.at(2).get_to(taken.stride);
    stored.at("parts").get_to(parts);
    strip = std::move(taken);
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace ilp::ground
