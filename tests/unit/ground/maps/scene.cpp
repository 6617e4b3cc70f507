#include "tests/unit/ground/maps/scene.hpp"

#include <gtest/gtest.h>
#include <ogr_spatialref.h>

#include <cmath>
#include <numbers>

#include "hal/maps/directory_map_source.hpp"
#include "sim/host/gdal_session.hpp"

namespace ilp::test {

void write_raster(const std::filesystem::path& path, const RasterFile& file,
                  const std::function<double(double, double)>& value) {
  const host::GdalSession session;
  const GDALDataType type = file.type == RasterFile::Type::f32   ? GDT_Float32
                            : file.type == RasterFile::Type::i16 ? GDT_Int16
                                                                 : GDT_Byte;
  char* sparse[] = {const_cast<char*>("SPARSE_OK=TRUE"), const_cast<char*>("TILED=YES"), nullptr};
  host::Dataset out(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(path.c_str(), file.columns, file.rows,
                                                                             file.bands, type, sparse));
  ASSERT_TRUE(out) << path;
  if (file.t[1] != 0) out->SetGeoTransform(const_cast<double*>(file.t));
  if (!file.system.empty()) {
    OGRSpatialReference system;
    ASSERT_EQ(system.importFromProj4(file.system.c_str()), OGRERR_NONE);
    out->SetSpatialRef(&system);
  }
  GDALRasterBand& band = *out->GetRasterBand(1);
  if (file.missing < 1e299) band.SetNoDataValue(file.missing);
  if (file.scale != 1) band.SetScale(file.scale);
  if (file.offset != 0) band.SetOffset(file.offset);
  if (!file.unit.empty()) band.SetUnitType(file.unit.c_str());
  if (file.empty) return;
  std::vector<float> row(static_cast<std::size_t>(file.columns));
  for (std::int32_t r = 0; r < file.rows; ++r) {
    for (std::int32_t c = 0; c < file.columns; ++c) {
      const double x = file.t[0] + (c + 0.5) * file.t[1] + (r + 0.5) * file.t[2];
      const double y = file.t[3] + (c + 0.5) * file.t[4] + (r + 0.5) * file.t[5];
      const double at = value(x, y);
      row[static_cast<std::size_t>(c)] =
          static_cast<float>(std::isfinite(at) ? (at - file.offset) / file.scale : file.missing);
    }
    ASSERT_EQ(band.RasterIO(GF_Write, 0, r, file.columns, 1, row.data(), file.columns, 1, GDT_Float32, 0, 0, nullptr),
              CE_None);
  }
}

int ReadMap::grey(std::uint32_t layer, std::int32_t column, std::int32_t row) const {
  if (column < 0 || row < 0) return 0;
  const std::size_t at = find_map_tile(*directory, layer, row / map_tile_side, column / map_tile_side);
  if (at == directory->tiles.size()) return 0;
  return tiles[at]->image[static_cast<std::size_t>(row % map_tile_side * map_tile_side + column % map_tile_side)];
}

maps::Place ReadMap::centre_of_light(std::uint32_t layer, maps::Place about, std::int32_t radius, double floor) const {
  const MapLayer& l = directory->layers[layer];
  const auto column = static_cast<std::int32_t>(std::floor((about.x - l.x0_m) / l.pixel_m));
  const auto row = static_cast<std::int32_t>(std::floor((l.y0_m - about.y) / l.pixel_m));
  double sum = 0, x = 0, y = 0;
  for (std::int32_t r = row - radius; r <= row + radius; ++r) {
    for (std::int32_t c = column - radius; c <= column + radius; ++c) {
      const double light = std::max(grey(layer, c, r) - floor, 0.0);
      sum += light;
      x += light * (l.x0_m + (c + 0.5) * l.pixel_m);
      y += light * (l.y0_m - (r + 0.5) * l.pixel_m);
    }
  }
  return {x / sum, y / sum};
}

ReadMap read_map(const std::filesystem::path& folder, std::span<const std::uint8_t> key) {
  ReadMap map;
  DirectoryMapSource source;
  EXPECT_TRUE(source.open(folder.c_str()).ok());
  std::vector<std::uint8_t> bytes(max_map_directory_bytes);
  std::size_t size = 0;
  EXPECT_TRUE(source.read_directory(bytes, size).ok()) << folder;
  EXPECT_TRUE(parse_map_directory(std::span(bytes).first(size), key, *map.directory).ok());
  const auto workspace = std::make_unique<MapTileWorkspace>();
  for (std::size_t i = 0; i < map.directory->tiles.size(); ++i) {
    const MapTileEntry& entry = map.directory->tiles[i];
    bytes.resize(limits::max_map_tile_bytes);
    EXPECT_TRUE(source.read_tile({entry.layer, entry.row, entry.column}, bytes, size).ok());
    map.tiles.push_back(std::make_unique<MapTile>());
    map.features.emplace_back();
    const std::span<const std::uint8_t> file = std::span(bytes).first(size);
    EXPECT_TRUE(decode_map_tile(file, *map.directory, i, *workspace, *map.tiles.back()).ok()) << i;
    EXPECT_TRUE(read_map_features(file, *map.directory, i, map.features.back()).ok()) << i;
  }
  return map;
}

maps::Place transverse_mercator(double radius_m, double longitude0, double latitude0, double longitude,
                                double latitude) {
  constexpr double radians = std::numbers::pi / 180;
  const double turn = (longitude - longitude0) * radians, phi = latitude * radians;
  return {radius_m * std::atanh(std::cos(phi) * std::sin(turn)),
          radius_m * (std::atan2(std::tan(phi), std::cos(turn)) - latitude0 * radians)};
}

}  // namespace ilp::test
