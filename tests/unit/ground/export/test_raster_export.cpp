// The rasters as other programs read them.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "sim/ground/export/cloud_tiff.hpp"
#include "sim/ground/export/raster_block.hpp"
#include "sim/ground/export/raster_export.hpp"
#include "sim/host/files.hpp"
#include "tests/support/said.hpp"
#include "tests/unit/ground/export/made_up_map.hpp"
#include "tests/unit/ground/export/strip_of_poses.hpp"
#include "tests/unit/ground/export/tool.hpp"
#include "tests/unit/ground/synthetic_flight.hpp"

namespace ilp::exports {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;
using test::quoted;
using test::run_tool;

const Anchors mars{find_body("mars"), {{1, 2, 137.4, -4.6, -4000, 0, 2.0}}};

class RasterExport : public ::testing::Test {
 protected:
  std::vector<std::string> write(const Anchors* anchors) {
    const intake::Flight flight = test::strip_of_poses(false);
    place_ = georeference_of(flight, flight.strips.at(1), anchors);
    return write_rasters(map_.mosaic(), place_, "", folder_.path());
  }
  /// What gdalinfo finds in the file, without computing anything.
  [[nodiscard]] json info(const std::string& name) const {
    const auto result = run_tool("gdalinfo -json " + quoted(folder_.path() / name));
    EXPECT_EQ(result.status, 0) << result.output;
    return json::parse(result.output);
  }
  [[nodiscard]] double value_at(const std::string& name, std::int32_t column, std::int32_t row) const {
    const auto result = run_tool("gdallocationinfo -valonly " + quoted(folder_.path() / name) + " " +
                                 std::to_string(column) + " " + std::to_string(row));
    EXPECT_EQ(result.status, 0) << result.output;
    if (result.output.find_first_not_of(" \n") != std::string::npos) return std::stod(result.output);
    // From GDAL 3.10 on it prints nothing where the file has no value.
    const json none = info(name).at("bands").at(0).at("noDataValue");
    return none.is_string() ? std::stod(none.get<std::string>()) : none.get<double>();
  }

  test::TemporaryFolder folder_;
  test::MadeUpMap map_;
  Georeference place_;
};

TEST_F(RasterExport, FiveCloudOptimisedFilesWithOverviewsNodataAndUnits) {
  ILP_NEED_TOOL("gdalinfo");
  EXPECT_EQ(write(nullptr),
            (std::vector<std::string>{"height.tif", "sigma.tif", "sigma-matching.tif", "count.tif", "ortho.tif"}));
  for (const auto& [name, unit, type] : {std::tuple("height.tif", "strip unit", "Float32"),
                                         {"sigma.tif", "strip unit", "Float32"},
                                         {"sigma-matching.tif", "strip unit", "Float32"},
                                         {"count.tif", "keyframes", "UInt16"},
                                         {"ortho.tif", "grey value", "Byte"}}) {
    const json found = info(name);
    const json& band = found.at("bands").at(0);
    EXPECT_EQ(found.at("size"), json({700, 600})) << name;
    EXPECT_EQ(found.at("metadata").at("IMAGE_STRUCTURE").at("LAYOUT"), "COG") << name;
    EXPECT_EQ(band.at("type"), type);
    EXPECT_EQ(band.at("unit"), unit) << name;
    EXPECT_FALSE(band.at("description").get<std::string>().empty()) << name;
    EXPECT_TRUE(band.contains("noDataValue")) << name;
    EXPECT_GE(band.at("overviews").size(), 1U) << name;
  }
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator(folder_.path())) ++files;
  EXPECT_EQ(files, 5U) << "nothing beside them";
}

TEST_F(RasterExport, StatisticsStandInTheFileAndAreThoseOfTheMap) {
  ILP_NEED_TOOL("gdalinfo");
  (void)write(nullptr);
  double sum = 0, least = 1e9, most = -1e9;
  int cells = 0;
  for (std::int32_t row = 0; row < map_.rows; ++row) {
    for (std::int32_t column = 0; column < map_.columns; ++column) {
      if (!map_.seen(column, row)) continue;
      const double z = map_.height(column, row);
      sum += z;
      least = std::min(least, z);
      most = std::max(most, z);
      ++cells;
    }
  }
  const json height = info("height.tif").at("bands").at(0).at("metadata").at("");
  const auto statistic = [&](const char* name) { return std::stod(height.at(name).get<std::string>()); };
  EXPECT_NEAR(statistic("STATISTICS_MEAN"), sum / cells, 1e-5);
  EXPECT_NEAR(statistic("STATISTICS_MINIMUM"), least, 1e-5);
  EXPECT_NEAR(statistic("STATISTICS_MAXIMUM"), most, 1e-5);
  EXPECT_NEAR(statistic("STATISTICS_VALID_PERCENT"), 100.0 * cells / (map_.columns * map_.rows), 0.01);
  for (const char* name : {"sigma.tif", "sigma-matching.tif", "count.tif", "ortho.tif"}) {
    EXPECT_TRUE(info(name).at("bands").at(0).at("metadata").at("").contains("STATISTICS_MEAN")) << name;
  }
}

TEST_F(RasterExport, EveryCellHasItsValueAndWhatWasNotSeenHasNone) {
  ILP_NEED_TOOL("gdallocationinfo");
  (void)write(nullptr);
  for (const auto& [column, row] : {std::pair(0, 0), std::pair(500, 420), std::pair(255, 256), std::pair(699, 599)}) {
    EXPECT_NEAR(value_at("height.tif", column, row), map_.height(column, row), 1e-5);
    EXPECT_NEAR(value_at("sigma.tif", column, row), map_.sigma(column), 1e-6);
    EXPECT_EQ(value_at("count.tif", column, row), map_.count(column));
    EXPECT_EQ(value_at("ortho.tif", column, row), std::max(1, int{map_.grey(column, row)}));
  }
  EXPECT_TRUE(std::isnan(value_at("height.tif", 120, 120)));
  EXPECT_TRUE(std::isnan(value_at("sigma.tif", 120, 120)));
  EXPECT_EQ(value_at("count.tif", 120, 120), 65535);
  EXPECT_EQ(value_at("ortho.tif", 120, 120), 0);
}

TEST_F(RasterExport, APlantedHeightIsAtItsLongitudeAndLatitude) {
  ILP_NEED_TOOL("gdallocationinfo");
  (void)write(&mars);
  // The world point of the spike, in metres from the anchored camera at (8, 2, 10), on a sphere of 3 396 190 m.
  const double east = 2 * (map_.x0 + map_.spike_column * map_.cell - 8);
  const double north = 2 * (map_.y0 - map_.spike_row * map_.cell - 2);
  const double degree = 3396190 * 3.14159265358979 / 180;
  std::ostringstream place;
  place.precision(12);
  place << 137.4 + east / (degree * std::cos(4.6 * 3.14159265358979 / 180)) << " " << -4.6 + north / degree;
  const auto pixel = run_tool("gdallocationinfo -valonly -l_srs IAU_2015:49900 " +
                              quoted(folder_.path() / "height.tif") + " " + place.str());
  ASSERT_EQ(pixel.status, 0) << pixel.output;
  const double z = map_.height(map_.spike_column, map_.spike_row);
  EXPECT_NEAR(std::stod(pixel.output), -4000 + 2 * (z - 10), 1e-2) << pixel.output;
}

TEST_F(RasterExport, TheCoordinateSystemNamesTheBodyAndItsRadius) {
  ILP_NEED_TOOL("gdalinfo");
  (void)write(&mars);
  const json found = info("height.tif");
  const std::string wkt = found.at("coordinateSystem").at("wkt");
  EXPECT_NE(wkt.find("PROJCRS[\"Mars, transverse Mercator about the anchor of strip 1\""), std::string::npos) << wkt;
  EXPECT_NE(wkt.find("ELLIPSOID[\"Mars (2015) - Sphere\",3396190,0"), std::string::npos) << wkt;
  EXPECT_EQ(found.at("bands").at(0).at("unit"), "metre");
}

TEST_F(RasterExport, InStripUnitsThereIsNoSystemThatReadersTakeToBeInMetres) {
  ILP_NEED_TOOL("gdalinfo");
  (void)write(nullptr);
  const json found = info("height.tif");
  EXPECT_TRUE(!found.contains("coordinateSystem") || found.at("coordinateSystem").at("wkt") == "") << found;
  EXPECT_EQ(found.at("bands").at(0).at("unit"), "strip unit");
  EXPECT_EQ(found.at("geoTransform"), json({-40.0625, 0.125, 0.0, 25.0625, 0.0, -0.125}));
}

TEST_F(RasterExport, GdaldemMakesAHillshadeOfIt) {
  ILP_NEED_TOOL("gdaldem");
  for (const Anchors* anchors : {static_cast<const Anchors*>(nullptr), &mars}) {
    (void)write(anchors);
    const fs::path shade = folder_.path() / "shade.tif";
    const auto result =
        run_tool("gdaldem hillshade -compute_edges " + quoted(folder_.path() / "height.tif") + " " + quoted(shade));
    ASSERT_EQ(result.status, 0) << result.output;
    // The plane's normal (-0.1, 0.05, 1) towards gdaldem's sun in the north-west, 45 degrees high.
    const double light = (0.1 * 0.5 + 0.05 * 0.5 + std::sqrt(0.5)) / std::sqrt(1 + 0.1 * 0.1 + 0.05 * 0.05);
    EXPECT_NEAR(value_at("shade.tif", 300, 300), 1 + 254 * light, 1);
    EXPECT_EQ(value_at("shade.tif", 120, 120), 0);
  }
}

TEST_F(RasterExport, TheSameMapGivesTheSameBytesInTilesOfAnySize) {
  (void)write(&mars);
  const auto bytes = [&] {
    std::vector<std::vector<std::uint8_t>> all;
    for (const char* name : {"height.tif", "sigma.tif", "sigma-matching.tif", "count.tif", "ortho.tif"}) {
      all.push_back(host::read_file(folder_.path() / name));
    }
    return all;
  };
  const auto first = bytes();
  map_.tile_side = 100;
  (void)write(&mars);
  EXPECT_TRUE(first == bytes());
}

/// The made-up map with digests of its tiles, which follow from where the spike is, and a count of tiles that are read.
class CountedTiles {
 public:
  explicit CountedTiles(const test::MadeUpMap& map) : mosaic_(map.mosaic()) {
    mosaic_.tile = [this, &map](std::int32_t column, std::int32_t row) {
      ++read_;
      return std::optional(map.tile(column, row));
    };
    mosaic_.digest = [&map](std::int32_t column, std::int32_t row) {
      const bool has_spike = map.spike_column / map.tile_side == column && map.spike_row / map.tile_side == row;
      intake::InputDigest digest("made-up");
      digest.add_value(std::min(map.tile_side, map.columns - column * map.tile_side));
      digest.add_value(std::min(map.tile_side, map.rows - row * map.tile_side))
          .add_value(column)
          .add_value(row)
          .add_value(has_spike ? map.spike_column : -1);
      return std::optional(digest.add_value(has_spike ? map.spike_row : -1).value());
    };
  }
  [[nodiscard]] const map::Mosaic& mosaic() const { return mosaic_; }
  [[nodiscard]] int read() const { return read_; }

 private:
  map::Mosaic mosaic_;
  std::atomic<int> read_{0};
};

TEST_F(RasterExport, TilesThatHaveNotChangedAreNotReadAgainAndTheBytesAreThoseOfAWholeRun) {
  map_.columns = 1500;
  map_.rows = 1300;
  (void)write(nullptr);
  const test::TemporaryFolder afresh;
  const auto same_as_afresh = [&] {
    (void)write_rasters(map_.mosaic(), place_, "", afresh.path());
    for (const char* name : {"height.tif", "sigma.tif", "sigma-matching.tif", "count.tif", "ortho.tif"}) {
      EXPECT_TRUE(host::read_file(folder_.path() / name) == host::read_file(afresh.path() / name)) << name;
    }
  };
  intake::MemoryResultCache kept;
  const auto tiles_read = [&] {
    const CountedTiles tiles(map_);
    (void)write_rasters(tiles.mosaic(), place_, "", folder_.path(), &kept);
    return tiles.read();
  };
  EXPECT_EQ(tiles_read(), 6 * 6);
  EXPECT_EQ(tiles_read(), 0);
  same_as_afresh();
  map_.spike_column += 3 * map_.tile_side;
  EXPECT_EQ(tiles_read(), 2) << "where the spike was, and where it is";
  same_as_afresh();
  // Another tile on the right and below: the blocks that end at the edge of the map have more cells now.
  map_.columns += map_.tile_side;
  map_.rows += map_.tile_side;
  EXPECT_LE(tiles_read(), 7 + 6 + 6 + 5);
  same_as_afresh();
}

TEST_F(RasterExport, AFileBeyondFourGibibytesIsABigTiffWithTheSameSamples) {
  ILP_NEED_TOOL("gdallocationinfo");
  (void)write(nullptr);
  // Two blocks and their overview, of a file of GDAL's own.
  const auto tile = run_tool(
      "gdal_translate -q -co TILED=YES -co BLOCKXSIZE=256 -co BLOCKYSIZE=256 -co COMPRESS=DEFLATE "
      "-co PREDICTOR=3 -srcwin 256 256 256 256 " +
      quoted(folder_.path() / "height.tif") + " " + quoted(folder_.path() / "head.tif"));
  ASSERT_EQ(tile.status, 0) << tile.output;
  std::vector<float> samples(block_samples, 7.5F);
  samples[3 * cloud_block_side + 5] = 9;
  const RasterBlock block = raster_block<HeightSample>(samples);
  std::vector<CloudLevel> levels = cloud_levels(500, 250);
  ASSERT_EQ(levels.size(), 2U);
  for (CloudLevel& level : levels) {
    for (std::uint32_t& bytes : level.block_bytes) bytes = static_cast<std::uint32_t>(block.coded.size());
  }
  const auto head = host::read_file(folder_.path() / "head.tif");
  const auto give = [&](std::size_t, std::size_t) { return block.coded; };
  for (const CloudFormat format : {CloudFormat::as_needed, CloudFormat::big}) {
    host::update_file(folder_.path() / "big.tif",
                      [&](std::ostream& out) { write_cloud_tiff(head, levels, give, out, format); });
    const auto bytes = host::read_file(folder_.path() / "big.tif");
    EXPECT_EQ(bytes[2], format == CloudFormat::big ? 43 : 42);
    EXPECT_EQ(info("big.tif").at("size"), json({500, 250}));
    EXPECT_EQ(info("big.tif").at("bands").at(0).at("overviews").at(0).at("size"), json({250, 125}));
    EXPECT_EQ(value_at("big.tif", 256 + 5, 3), 9);
    EXPECT_EQ(value_at("big.tif", 256 + 6, 3), 7.5);
  }
}

TEST_F(RasterExport, SigmaThatIsToldNowhereHasNoFile) {
  (void)write(nullptr);
  map_.sigma_given = false;
  EXPECT_EQ(write(nullptr), (std::vector<std::string>{"height.tif", "count.tif", "ortho.tif"}));
  EXPECT_FALSE(fs::exists(folder_.path() / "sigma.tif")) << "of an earlier map";
}

TEST_F(RasterExport, AMapThatBreaksOffLeavesTheEarlierFilesAndNoHalfOnes) {
  (void)write(nullptr);
  const auto before = host::read_file(folder_.path() / "height.tif");
  map::Mosaic mosaic = map_.mosaic();
  mosaic.tile = [&](std::int32_t column, std::int32_t row) -> std::optional<map::MapTile> {
    if (row > 0) throw std::runtime_error("the tile cannot be read");
    return map_.tile(column, row);
  };
  EXPECT_THROW(write_rasters(mosaic, place_, "", folder_.path()), std::runtime_error);
  EXPECT_TRUE(before == host::read_file(folder_.path() / "height.tif"));
  for (const auto& entry : fs::directory_iterator(folder_.path())) EXPECT_EQ(entry.path().extension(), ".tif");
}

TEST_F(RasterExport, AFolderThatCannotBeWrittenIsSaid) {
  const auto write = [&] { (void)write_rasters(map_.mosaic(), place_, "", folder_.path() / "none"); };
  EXPECT_TRUE(test::says(test::error_of(write), "height.tif"));
}

TEST_F(RasterExport, TheTextureIsTheOrthoimageAtASize) {
  (void)write(nullptr);
  const host::Raster<std::uint8_t> whole = read_ortho(folder_.path() / "ortho.tif", 1000);
  EXPECT_TRUE(whole.same_size(700, 600));
  EXPECT_EQ(whole.at(33, 44), 77);
  const host::Raster<std::uint8_t> small = read_ortho(folder_.path() / "ortho.tif", 350);
  EXPECT_TRUE(small.same_size(350, 300));
}

}  // namespace
}  // namespace ilp::exports
