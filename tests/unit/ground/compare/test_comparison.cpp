// Terrains whose difference is known: by a shift, a turn, another coordinate system, noise, holes and cliffs.
#include <gtest/gtest.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "sim/ground/compare/comparison.hpp"
#include "tests/unit/ground/compare/terrain_file.hpp"
#include "tests/unit/ground/export/tool.hpp"
#include "tests/unit/host/scratch_folder.hpp"

namespace ilp {
namespace {

using compare::Comparison;
using compare::ComparisonOptions;
using compare::Fit;
using test::hills;
using test::TerrainFile;
using test::write_terrain;

constexpr double none = std::numeric_limits<double>::quiet_NaN();
const std::string mars_mercator =
    "PROJCRS[\"Mars, transverse Mercator\",BASEGEOGCRS[\"Mars (2015) - Sphere\",DATUM[\"Mars (2015) - Sphere\","
    "ELLIPSOID[\"Mars (2015) - Sphere\",3396190,0]]],CONVERSION[\"about an anchor\",METHOD[\"Transverse Mercator\"],"
    "PARAMETER[\"Latitude of natural origin\",-4.5,ANGLEUNIT[\"degree\",0.0174532925199433]],"
    "PARAMETER[\"Longitude of natural origin\",-10,ANGLEUNIT[\"degree\",0.0174532925199433]],"
    "PARAMETER[\"Scale factor at natural origin\",1],PARAMETER[\"False easting\",0],PARAMETER[\"False "
    "northing\",0]],CS[Cartesian,2],AXIS[\"x\",east],AXIS[\"y\",north],LENGTHUNIT[\"metre\",1]]";
const std::string mars_degrees = "IAU_2015:49900";

TerrainFile on_mars() {
  TerrainFile file{.system = mars_mercator};
  return file;
}

/// Larger than the map by 100 m on each side.
TerrainFile around() {
  TerrainFile file = on_mars();
  file.transform = {-100, 2.5, 0, 100, 0, -2.5};
  file.columns = 320;
  file.rows = 272;
  return file;
}

class CompareHeights : public ::testing::Test {
 protected:
  Comparison run(ComparisonOptions options = {}) {
    options.map = map_;
    options.other = other_;
    options.out = folder_ / "out";
    return compare::compare_heights(options);
  }
  static ComparisonOptions fit(Fit fit) {
    ComparisonOptions options;
    options.alignment.fit = fit;
    return options;
  }
  /// Normal noise, the same in each run.
  double noise(double sigma) { return sigma * normal_(random_); }

  test::ScratchFolder folder_;
  std::filesystem::path map_ = folder_ / "height.tif", other_ = folder_ / "other.tif";

 private:
  std::mt19937 random_{7};
  std::normal_distribution<double> normal_;
};

TEST_F(CompareHeights, AKnownShiftIsFoundUnderNoiseToASmallPartOfACell) {
  write_terrain(map_, on_mars(), [&](double x, double y) { return hills(x - 23.4, y + 11.7) + 5.25 + noise(0.3); });
  write_terrain(other_, around(), hills);
  const Comparison c = run();
  ASSERT_TRUE(c.alignment.aligned && c.alignment.horizontal);
  EXPECT_NEAR(c.alignment.shift.x(), -23.4, 0.04);
  EXPECT_NEAR(c.alignment.shift.y(), 11.7, 0.04);
  EXPECT_NEAR(c.alignment.shift.z(), -5.25, 0.02);
  EXPECT_GT(c.alignment.before.rmse, 5);
  EXPECT_LT(c.alignment.residual.norm(), 0.1);
  EXPECT_NEAR(c.difference.nmad, 0.3, 0.02);
  EXPECT_NEAR(c.difference.median, 0, 0.02);
}

TEST_F(CompareHeights, AFarShiftIsFoundFromCoarseToFine) {
  write_terrain(map_, on_mars(), [](double x, double y) { return hills(x + 61, y - 47) - 300; });
  write_terrain(other_, around(), hills);
  const Comparison c = run();
  EXPECT_NEAR(c.alignment.shift.x(), 61, 0.1);
  EXPECT_NEAR(c.alignment.shift.y(), -47, 0.1);
  EXPECT_NEAR(c.alignment.shift.z(), 300, 0.05);
}

TEST_F(CompareHeights, SpikesOnATenthOfTheCellsDoNotMoveIt) {
  int cell = 0;
  write_terrain(map_, on_mars(),
                [&](double x, double y) { return hills(x - 6, y - 3) + noise(0.2) + (++cell % 10 == 0 ? 80.0 : 0.0); });
  write_terrain(other_, around(), hills);
  const Comparison c = run();
  EXPECT_NEAR(c.alignment.shift.x(), -6, 0.05);
  EXPECT_NEAR(c.alignment.shift.y(), -3, 0.05);
  EXPECT_NEAR(c.alignment.shift.z(), 0, 0.03);
  // The mean follows the spikes, the median and the NMAD do not.
  EXPECT_NEAR(c.difference.mean, 8, 0.3);
  EXPECT_NEAR(c.difference.median, 0, 0.1);
  EXPECT_LT(c.difference.nmad, 0.4);
}

TEST_F(CompareHeights, ASimilarityIsFoundWhereAShiftIsNotEnough) {
  const double turn = 0.01, scale = 1.004;
  const auto turned = [&](double x, double y) {
    const double u = scale * (std::cos(turn) * x - std::sin(turn) * y) + 4;
    const double v = scale * (std::sin(turn) * x + std::cos(turn) * y) - 7;
    return hills(u, v) / scale - 0.002 * x;
  };
  write_terrain(map_, on_mars(), turned);
  write_terrain(other_, around(), hills);
  const Comparison shifted = run();
  EXPECT_GT(shifted.difference.nmad, 0.5);
  const Comparison c = run(fit(Fit::similarity));
  EXPECT_NEAR(c.alignment.moved.scale, scale, 2e-4);
  EXPECT_NEAR(c.alignment.turn_rad.z(), turn, 3e-4);
  EXPECT_NEAR(c.alignment.turn_rad.y(), -0.002, 3e-4);
  EXPECT_LT(c.difference.nmad, 0.05);
  EXPECT_NEAR(c.cell, 2 * scale, 1e-3);
}

TEST_F(CompareHeights, AModelInDegreesOfTheSameBodyLiesWhereItIs) {
  // Longitudes from 0 to 360, and the map at -10 degrees.
  OGRSpatialReference degrees, metres;
  degrees.SetFromUserInput(mars_degrees.c_str());
  metres.SetFromUserInput(mars_mercator.c_str());
  degrees.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  OGRCoordinateTransformation* const way = OGRCreateCoordinateTransformation(&degrees, &metres);
  ASSERT_NE(way, nullptr);
  TerrainFile file{.system = mars_degrees};
  const double step = 1.5 / 3396190 * 180 / std::numbers::pi;
  file.columns = 520;
  file.rows = 440;
  file.transform = {350 - 80 * step, step, 0, -4.5 + 60 * step, 0, -step};
  write_terrain(other_, file, [&](double x, double y) {
    EXPECT_TRUE(way->Transform(1, &x, &y));
    return hills(x, y);
  });
  OGRCoordinateTransformation::DestroyCT(way);
  write_terrain(map_, on_mars(), hills);
  const Comparison c = run(fit(Fit::none));
  EXPECT_EQ(c.counts.compared, 300U * 240U);
  // What is left is the bilinear interpolation between posts 1.5 m apart.
  EXPECT_LT(c.difference.abs_95, 0.03);
  EXPECT_NEAR(c.other_cell, 1.5, 0.01);
}

TEST_F(CompareHeights, AFinerModelIsAveragedToTheCellsOfTheMap) {
  TerrainFile fine = around();
  fine.transform = {-100, 0.5, 0, 100, 0, -0.5};
  fine.columns = 1600;
  fine.rows = 1360;
  write_terrain(other_, fine, [&](double x, double y) { return hills(x, y) + noise(1); });
  write_terrain(map_, on_mars(), hills);
  const Comparison c = run();
  EXPECT_NEAR(c.other_cell, 2, 1e-6);
  // Noise of 1 m, averaged over 16 pixels, is 0.25 m; beside it, at most what four cells of one height differ.
  EXPECT_LT(c.difference.nmad, 0.27);
}

TEST_F(CompareHeights, WhatNobodyDeclaredMissingIsNotCompared) {
  TerrainFile fine = around();
  fine.transform = {-100, 0.5, 0, 100, 0, -0.5};
  fine.columns = 1600;
  fine.rows = 1360;
  fine.declares_missing = false;
  int pixel = 0;
  write_terrain(other_, fine, [&](double x, double y) { return ++pixel % 97 == 0 ? -9999 : hills(x, y); });
  write_terrain(map_, on_mars(), hills);
  const Comparison c = run(fit(Fit::none));
  EXPECT_GT(c.counts.compared, 250U * 200U);
  // Averaged over 16 pixels, one that counts would be 600 m.
  EXPECT_LT(c.difference.nmad, 0.05);
  EXPECT_LT(std::fabs(c.difference.mean), 0.05);
}

TEST_F(CompareHeights, OverLevelGroundOnlyHeightsAreAligned) {
  write_terrain(map_, on_mars(), [&](double, double) { return 12 + noise(0.1); });
  write_terrain(other_, around(), [](double, double) { return 10; });
  const Comparison c = run();
  EXPECT_TRUE(c.alignment.aligned);
  EXPECT_FALSE(c.alignment.horizontal);
  EXPECT_EQ(c.alignment.shift.x(), 0);
  EXPECT_NEAR(c.alignment.shift.z(), -2, 0.01);
  ASSERT_FALSE(c.remarks.empty());
  EXPECT_TRUE(test::says(c.remarks.back(), "does not determine a shift in x and y"));
}

TEST_F(CompareHeights, WhatIsLeftOutIsCountedByItsReason) {
  // The map: 300 x 240 cells of 2 m, 30 columns of them without a height. The other model ends at x = 500, has a hole
  // of 100 m x 80 m, and a ramp of 63 degrees between x = 300 and 320.
  write_terrain(map_, on_mars(), [](double x, double) { return x > 540 ? none : 0; });
  TerrainFile other = on_mars();
  other.transform = {-3, 2, 0, 3, 0, -2};
  other.columns = 252;  // centres up to x = 500
  other.rows = 246;
  write_terrain(other_, other, [](double x, double y) {
    if (x > 100 && x < 200 && y < -100 && y > -180) return none;
    return x < 300 ? 0 : std::min(2 * (x - 300), 40.0);
  });
  const Comparison c = run(fit(Fit::none));
  EXPECT_EQ(c.counts.without_height, 30U * 240U);
  EXPECT_EQ(c.counts.outside, 20U * 240U);
  EXPECT_GE(c.counts.without_other, 50U * 40U);
  EXPECT_LE(c.counts.without_other, 53U * 43U);
  EXPECT_GE(c.counts.steep, 9U * 240U);
  EXPECT_LE(c.counts.steep, 11U * 240U);
  EXPECT_EQ(c.counts.without_height + c.counts.outside + c.counts.without_other + c.counts.steep + c.counts.compared,
            300U * 240U);
  const std::vector<float> values = test::values_of(folder_ / "out" / "difference.tif");
  EXPECT_EQ(
      static_cast<std::uint64_t>(std::count_if(values.begin(), values.end(), [](float v) { return std::isfinite(v); })),
      c.counts.compared);
}

TEST_F(CompareHeights, StatisticsAreThoseOfTheSortedValues) {
  write_terrain(map_, on_mars(), [&](double x, double y) { return hills(x, y) + noise(0.5) * noise(0.5) + 0.1; });
  write_terrain(other_, around(), hills);
  const Comparison c = run(fit(Fit::none));
  std::vector<float> values = test::values_of(folder_ / "out" / "difference.tif");
  std::erase_if(values, [](float v) { return !std::isfinite(v); });
  ASSERT_EQ(values.size(), c.difference.count);
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    return double{values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)]};
  };
  const double median = at(0.5);
  EXPECT_EQ(c.difference.median, median);
  EXPECT_EQ(c.difference.least, double{values.front()});
  EXPECT_EQ(c.difference.most, double{values.back()});
  double squares = 0;
  for (const float v : values) squares += double{v} * double{v};
  EXPECT_NEAR(c.difference.rmse, std::sqrt(squares / static_cast<double>(values.size())), 1e-9);
  std::vector<float> distances;
  for (const float v : values) distances.push_back(std::fabs(v - static_cast<float>(median)));
  for (float& v : values) v = std::fabs(v);
  std::sort(values.begin(), values.end());
  EXPECT_EQ(c.difference.abs_68, at(0.683));
  EXPECT_EQ(c.difference.abs_95, at(0.95));
  values = distances;
  std::sort(values.begin(), values.end());
  EXPECT_NEAR(c.difference.nmad, 1.4826 * at(0.5), 1e-9);
  std::uint64_t all = c.difference.histogram.outside;
  for (const std::uint64_t count : c.difference.histogram.counts) all += count;
  EXPECT_EQ(all, c.difference.count);
}

TEST_F(CompareHeights, StatedErrorsHoldTheSharesOfANormalDistribution) {
  const auto sigma = [](double x) { return 0.2 + 0.001 * x; };
  write_terrain(map_, on_mars(), [&](double x, double y) { return hills(x, y) + noise(sigma(x)); });
  write_terrain(folder_ / "sigma.tif", on_mars(), [&](double x, double) { return sigma(x); });
  // A part of the error is stated beside it: half of it.
  write_terrain(folder_ / "sigma-matching.tif", on_mars(), [&](double x, double) { return 0.5 * sigma(x); });
  TerrainFile same = on_mars();
  same.transform = {-2, 2, 0, 2, 0, -2};
  same.columns = 302;
  same.rows = 242;
  write_terrain(other_, same, hills);
  const Comparison c = run(fit(Fit::none));
  ASSERT_EQ(c.counts.sigma.stated, 300U * 240U);
  EXPECT_NEAR(static_cast<double>(c.counts.sigma.one) / 72000, 0.683, 0.006);
  EXPECT_NEAR(static_cast<double>(c.counts.sigma.two) / 72000, 0.954, 0.003);
  ASSERT_EQ(c.counts.matching.stated, 300U * 240U);
  EXPECT_NEAR(static_cast<double>(c.counts.matching.one) / 72000, 0.383, 0.006) << "within half a sigma";
  EXPECT_NEAR(static_cast<double>(c.counts.matching.two) / 72000, 0.683, 0.006);
}

TEST_F(CompareHeights, TheDifferenceLiesWhereTheMapWasMoved) {
  // A mound on the map that the other model has not.
  const auto mound = [](double x, double y) { return std::hypot(x - 300, y + 200) < 20 ? 8.0 : 0.0; };
  write_terrain(map_, on_mars(), [&](double x, double y) { return hills(x - 10, y) + mound(x, y); });
  write_terrain(other_, around(), hills);
  (void)run();
  ILP_NEED_TOOL("gdallocationinfo");
  const auto at = [&](const std::string& place) {
    return std::stod(test::run_tool("gdallocationinfo -valonly -geoloc " +
                                    test::quoted(folder_ / "out" / "difference.tif") + " " + place)
                         .output);
  };
  EXPECT_NEAR(at("290 -200"), 8, 0.2);
  EXPECT_NEAR(at("290 -182"), 8, 0.2);
  EXPECT_NEAR(at("317 -200"), 0, 0.2);
}

TEST_F(CompareHeights, TheProgramWritesItsFilesAndEndsWithZero) {
  write_terrain(map_, on_mars(), hills);
  write_terrain(other_, around(), [](double x, double y) { return hills(x, y) + 1; });
  const test::ToolResult ran = test::run_tool(std::string(ILP_GROUND_PROGRAM) + " compare " +
                                              test::quoted(folder_.path()) + " " + test::quoted(other_) + " 2>&1");
  ASSERT_EQ(ran.status, 0) << ran.output;
  EXPECT_TRUE(test::says(ran.output, "the map was moved by"));
  const std::filesystem::path out = folder_ / "comparison";
  const auto reported = nlohmann::json::parse(std::ifstream(out / "comparison.json"));
  EXPECT_NEAR(reported.at("alignment").at("shift_m").at(2).get<double>(), 1, 0.01);
  EXPECT_EQ(reported.at("cells").at("compared").get<int>(), 300 * 240);
  EXPECT_TRUE(std::filesystem::exists(out / "difference.png"));
  EXPECT_TRUE(test::says(test::text_of(out / "comparison.html"), "data:image/png"));
}

struct BadModel {
  const char* name;
  TerrainFile file;
  double height;
  const char* reported;
};

void PrintTo(const BadModel& bad, std::ostream* to) {
  *to << bad.name;
}

TerrainFile changed(const std::function<void(TerrainFile&)>& change) {
  TerrainFile file = on_mars();
  change(file);
  return file;
}

class BadTerrainModel : public ::testing::TestWithParam<BadModel> {};

TEST_P(BadTerrainModel, IsRefusedWithItsReason) {
  const test::ScratchFolder folder;
  write_terrain(folder / "height.tif", on_mars(), hills);
  write_terrain(folder / "other.tif", GetParam().file, [&](double, double) { return GetParam().height; });
  ComparisonOptions options{.map = folder.path(), .other = folder / "other.tif"};
  const std::string error = test::error_of([&] { (void)compare::compare_heights(options); });
  EXPECT_TRUE(test::says(error, GetParam().reported));
  EXPECT_TRUE(test::says(error, "other.tif"));
  EXPECT_FALSE(std::filesystem::exists(folder / "comparison" / "difference.tif"));
}

INSTANTIATE_TEST_SUITE_P(
    Of, BadTerrainModel,
    ::testing::Values(
        BadModel{"Elsewhere", changed([](TerrainFile& f) { f.transform[0] = 90000; }), 1, "do not overlap"},
        BadModel{"AnotherBody", changed([](TerrainFile& f) { f.system = "IAU_2015:30100"; }), 1, "another body"},
        BadModel{"WithoutASystem", changed([](TerrainFile& f) { f.system = ""; }), 1, "states no coordinate system"},
        BadModel{"LocalAxes", changed([](TerrainFile& f) { f.system = "LOCAL_CS[\"local\",UNIT[\"metre\",1]]"; }), 1,
                 "local axes"},
        BadModel{"OnePixel", changed([](TerrainFile& f) { f.columns = f.rows = 1; }), 1, "1x1 pixels"},
        BadModel{"WithoutData", on_mars(), none, "no data"},
        BadModel{"InColour", changed([](TerrainFile& f) { f.bands = 3; }), 1, "3 bands"},
        BadModel{"InAnotherUnit", changed([](TerrainFile& f) { f.unit = "kelvin"; }), 1, "unit \"kelvin\""},
        BadModel{"WithoutSize", changed([](TerrainFile& f) { f.transform = {5, 2, 0, 5, 0, 0}; }), 1, "no size"}),
    [](const auto& bad) { return std::string(bad.param.name); });

TEST_F(CompareHeights, FilesThatAreNoModelsAreRefused) {
  const auto refused = [&] { return test::error_of([&] { (void)run(); }); };
  write_terrain(map_, on_mars(), [](double, double) { return none; });
  write_terrain(other_, around(), hills);
  EXPECT_TRUE(test::says(refused(), "no cell of the map has a height"));
  write_terrain(map_, on_mars(), hills);
  folder_.write("other.tif", "no raster at all");
  EXPECT_TRUE(test::says(refused(), "not a raster that GDAL reads"));
  other_ = folder_ / "absent.tif";
  EXPECT_TRUE(test::says(refused(), "there is no such file"));
  map_ = folder_ / "empty";
  std::filesystem::create_directory(map_);
  EXPECT_TRUE(test::says(refused(), "neither height.tif nor ground/height.tif"));
  // A damaged raster: the end is missing.
  map_ = folder_ / "height.tif";
  other_ = folder_ / "cut.tif";
  write_terrain(other_, around(), hills);
  std::filesystem::resize_file(other_, 60000);
  EXPECT_FALSE(refused().empty());
}

TEST_F(CompareHeights, AMapInTheAxesOfItsStripNeedsAPlace) {
  TerrainFile local;
  local.system = "LOCAL_CS[\"Strip 1, local axes\",UNIT[\"metre\",1]]";
  write_terrain(map_, local, hills);
  write_terrain(other_, around(), hills);
  EXPECT_TRUE(test::says(test::error_of([&] { (void)run(); }), "--anchor"));
  ComparisonOptions options;
  options.frame.same_axes = true;
  EXPECT_LT(run(options).difference.nmad, 0.05);
}

TEST_F(CompareHeights, PosesOfTheImagesPlaceAMapInStripUnits) {
  // The strip: turned by 1 rad, with a unit of 5 m.
  const double turn = 1, unit = 5;
  const auto world = [&](double x, double y) {
    return Vec3(unit * (std::cos(turn) * x - std::sin(turn) * y) + 150,
                unit * (std::sin(turn) * x + std::cos(turn) * y) - 90, 0);
  };
  TerrainFile local;
  local.system = "LOCAL_CS[\"Strip 1, local axes, in strip units\",UNIT[\"metre\",1]]";
  local.unit = "strip unit";
  local.transform = {0, 0.4, 0, 0, 0, -0.4};
  local.columns = 100;
  local.rows = 90;
  write_terrain(map_, local, [&](double x, double y) {
    const Vec3 place = world(x, y);
    return (hills(place.x(), place.y()) - 20) / unit;
  });
  TerrainFile other = around();
  other.transform = {-100, 2, 0, 300, 0, -2};
  other.columns = other.rows = 300;
  other.system = "LOCAL_CS[\"Axes of the world\",UNIT[\"metre\",1]]";
  write_terrain(other_, other, hills);
  std::string table = "name,strip,x,y,z,q_w,q_x,q_y,q_z\n", poses;
  for (int i = 0; i < 5; ++i) {
    // Looks down, x of the image to the east of the strip.
    const double x = 8 * i, y = -10 - 3 * (i % 2), z = 40;
    table += "img" + std::to_string(i) + ".png,1," + std::to_string(x) + "," + std::to_string(y) + "," +
             std::to_string(z) + ",0,1,0,0\n";
    const Vec3 centre = world(x, y) + Vec3(0, 0, unit * z + 20);
    const double c = std::cos(turn), s = std::sin(turn);
    for (const auto& word : {"img" + std::to_string(i), std::string("640 480 500 500 320 240")}) poses += word + " ";
    for (const double r : {c, s, 0.0, s, -c, 0.0, 0.0, 0.0, -1.0}) poses += std::to_string(r) + " ";
    for (int k = 0; k < 3; ++k) poses += std::to_string(centre(k)) + " ";
    poses += "\n";
  }
  folder_.write("keyframes.csv", table);
  ComparisonOptions options = fit(Fit::none);
  options.frame.poses = folder_.write("poses.txt", poses);
  const Comparison c = run(options);
  EXPECT_NEAR(c.cell, 2, 1e-4);
  EXPECT_EQ(c.counts.compared, 100U * 90U);
  EXPECT_LT(c.difference.abs_95, 0.1);
  EXPECT_NEAR(c.difference.median, 0, 0.02);
  // Of other images.
  options.frame.poses = folder_.write("others.txt", "a 640 480 500 500 320 240 1 0 0 0 1 0 0 0 1 0 0 0\n");
  EXPECT_TRUE(test::says(test::error_of([&] { (void)run(options); }), "names 0 posed keyframes of the map"));
}

}  // namespace
}  // namespace ilp
