// What people bring, as recorded cases (../shared/data/cases): each gives its right value, or a refusal that names the
// cause. Skipped where they are not there; the unit tests make small files of the same kinds.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "sim/host/geo_raster.hpp"
#include "tests/unit/ground/export/tool.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

const fs::path cases = fs::path(ILP_SOURCE_DIR) / "../shared/data/cases", demo = fs::path(ILP_SOURCE_DIR) / "sim/demo";

class BroughtFiles : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::is_directory(cases)) GTEST_SKIP() << "no recorded cases in " << cases;
  }
  test::ToolResult fly(const std::string& options, const std::string& out = "out") {
    return test::run_tool(std::string(ILP_SIL) + " " + options + " --out " + test::quoted(folder_ / out) + " 2>&1");
  }
  test::ToolResult fly_photographs(const std::string& name) {
    return fly("--images " + (cases / name / "photographs").string() + " --camera " +
               (cases / name / "cameras.txt").string());
  }
  void expect_reported(const test::ToolResult& result, int status, const std::vector<const char*>& parts) {
    EXPECT_EQ(result.status, status) << result.output;
    for (const char* part : parts)
      EXPECT_NE(result.output.find(part), std::string::npos) << part << "\n" << result.output;
  }
  std::vector<double> index_times() const {
    std::vector<double> times;
    std::ifstream index(folder_ / "out/frames.txt");
    for (std::string line; std::getline(index, line);) {
      if (!line.empty() && line[0] != '#') times.push_back(std::stod(line) / 1e9);
    }
    return times;
  }
  /// Columns of exif-positions.csv.
  std::vector<std::vector<std::string>> positions() const {
    std::vector<std::vector<std::string>> rows;
    std::ifstream file(folder_ / "out/exif-positions.csv");
    for (std::string line; std::getline(file, line);) {
      if (line.empty() || line[0] == '#' || line[0] == 't') continue;
      std::vector<std::string>& row = rows.emplace_back(1);
      for (const char c : line) {
        if (c == ',')
          row.emplace_back();
        else
          row.back() += c;
      }
    }
    return rows;
  }

  const test::TemporaryFolder folder_;
};

TEST_F(BroughtFiles, OrderAndTimesOfPhotographs) {
  expect_reported(fly_photographs("counter-rolls-over"), 0, {"not that of the names", "14 frames"});
  ASSERT_EQ(index_times().size(), 14U);
  for (std::size_t i = 0; i < 14; ++i) EXPECT_EQ(index_times()[i], 5.0 * static_cast<double>(i));
}

TEST_F(BroughtFiles, FilesThatAreNoImages) {
  expect_reported(fly_photographs("dot-underscore-files"), 0, {"6 frames"});
  EXPECT_EQ(index_times(), (std::vector<double>{0, 5, 10, 15, 20, 25}));
}

TEST_F(BroughtFiles, PositionsThatAreRoundedOrUnknown) {
  expect_reported(fly_photographs("exif-sixty-seconds"), 0, {"in 6 of 6 images"});
  for (const auto& row : positions()) EXPECT_NEAR(std::stod(row[2]), 47.3, 1e-4);
  fs::remove_all(folder_ / "out");
  expect_reported(fly_photographs("exif-altitude-unknown"), 0, {"in 8 of 8 images"});
  for (const auto& row : positions()) EXPECT_EQ(row[4] + row[5], "");
}

TEST_F(BroughtFiles, SeveralSizesAndLenses) {
  expect_reported(fly_photographs("thermal-beside-visible"), 0,
                  {"left out: 7 photographs of 14 with another size", "7 frames"});
  fs::remove_all(folder_ / "out");
  expect_reported(fly_photographs("zoom-lens"), 0, {"7 photographs of 14 with another focal length", "IMG_0008.JPG"});
}

TEST_F(BroughtFiles, DamagedPhotographs) {
  const fs::path damaged = cases / "damaged-photographs";
  const auto flown = [&](const char* kind, const char* camera) {
    return fly("--images " + (damaged / kind).string() + " --camera " + (damaged / camera).string(), kind);
  };
  expect_reported(flown("jpeg", "cameras.txt"), 0, {"IMG_0003.JPG: damaged", "IMG_0004.JPG: damaged", "3 frames"});
  expect_reported(flown("png16", "cameras-160.txt"), 0, {"c_0002.png: damaged", "2 frames"});
  expect_reported(flown("tiff", "cameras-160.txt"), 0, {"t_0002.tif: damaged", "2 frames"});
}

TEST_F(BroughtFiles, KindsOfPictures) {
  const fs::path tiff = cases / "float-and-palette-tiff";
  expect_reported(fly("--images " + (tiff / "float").string(), "float"), 1,
                  {"samples of the type Float32", "convert it"});
  expect_reported(
      fly("--images " + (tiff / "palette").string() + " --camera " + (tiff / "cameras.txt").string(), "palette"), 0,
      {"3 frames"});
}

TEST_F(BroughtFiles, HeadersOfVideos) {
  const auto flown = [&](const std::string& name) {
    return fly("--y4m " + (cases / "video-headers" / (name + ".y4m")).string() + " --camera " +
                   (cases / "video-headers/cameras.txt").string(),
               name);
  };
  for (const char* deep : {"ten-bit", "mono10"}) expect_reported(flown(deep), 1, {"10 bits per sample, 8 expected"});
  for (const char* timeless : {"no-rate", "rate-unknown"}) expect_reported(flown(timeless), 1, {"--frame-rate"});
  // Their two keyframes give no pose.
  expect_reported(flown("long-header"), 3, {"3 frames"});
  expect_reported(flown("interlaced"), 3, {"is interlaced"});
  expect_reported(flown("wide-pixels"), 3, {"no squares"});
  expect_reported(flown("mono-tagged-420"), 4, {"breaks off"});
}

TEST_F(BroughtFiles, MeasurementsOfAnotherClock) {
  const fs::path folder = cases / "navigation-times-from-1970";
  const auto flown = [&](const std::string& name) {
    return fly("--images " + demo.string() + " --camera " + (demo / "cameras.txt").string() + " --navigation " +
                   (folder / (name + ".csv")).string() + " --mission " + (folder / "mission.ini").string(),
               name);
  };
  expect_reported(flown("since-1970"), 0,
                  {"156 lines with a date or a time since 1970 cannot be used", "none is used"});
  expect_reported(flown("iso-8601"), 0, {"156 lines with a date", "none is used"});
  const auto notes = nlohmann::json::parse(std::ifstream(folder_ / "iso-8601/flight-info.json"))["notes"];
  EXPECT_GE(notes.size(), 2U) << "the report says it too";
  for (const char* name : {"semicolons", "bom"}) {
    const test::ToolResult result = flown(name);
    expect_reported(result, 0, {"is read as"});
    EXPECT_EQ(result.output.find("none is used"), std::string::npos) << result.output;
  }
}

TEST_F(BroughtFiles, TerrainsInAllUnits) {
  for (const char* name : {"metres", "scaled", "feet", "state-plane-feet"}) {
    const test::ToolResult result =
        fly("--set world.heightmap=" + (cases / "heightmap-scale-and-unit" / name).string() +
                ".tif --set flight.kind=line --set flight.altitude_m=1500 --set world.post_spacing_m=4 --frames 2 "
                "--render-only",
            name);
    ASSERT_EQ(result.status, 0) << result.output;
    const host::GeoRaster truth = host::read_raster(folder_ / (std::string(name) + "/flight/truth/height.tif"));
    float lowest = 1e9F, highest = -1e9F;
    for (const float height : truth.values.samples) {
      if (!std::isfinite(height)) continue;
      lowest = std::min(lowest, height);
      highest = std::max(highest, height);
    }
    EXPECT_NEAR(highest - lowest, 83.8, 0.2) << name;
  }
  expect_reported(fly("--set world.heightmap=" + (cases / "heightmap-scale-and-unit/undeclared-nodata.tif").string() +
                          " --set flight.kind=line --set flight.altitude_m=1500 --frames 2 --render-only",
                      "holes"),
                  1, {"have no value", "fill_holes = true"});
}

}  // namespace
}  // namespace ilp
