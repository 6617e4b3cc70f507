// All exports of a flight over a known plane, from its outbox, as other programs read them.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "sim/ground/ground_run.hpp"
#include "tests/support/said.hpp"
#include "tests/unit/ground/export/tool.hpp"
#include "tests/unit/ground/synthetic_flight.hpp"

namespace ilp::exports {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;
using test::quoted;
using test::run_tool;

class ExportsOfAFlight : public ::testing::Test {
 protected:
  void SetUp() override { test::write_outbox(test::make_flight(false), folder_.path() / "outbox"); }

  /// The origin of strip 1 at 10 E, 20 N on Mars, 2000 m below the sphere; a strip unit is 2 m.
  [[nodiscard]] ground::GroundOptions anchored(const std::string& flight_info) const {
    std::ofstream(folder_.path() / "anchor.json")
        << R"({"body": "mars", "strips": [{"strip": 1, "longitude": 10, "latitude": 20, "height": -2000,
                                           "metres_per_unit": 2}]})";
    std::ofstream(folder_.path() / "info.json") << flight_info;
    ground::GroundOptions options;
    options.outbox = folder_.path() / "outbox";
    options.out = out();
    options.anchor = folder_.path() / "anchor.json";
    options.flight_info = folder_.path() / "info.json";
    return options;
  }
  [[nodiscard]] fs::path out() const { return folder_.path() / "ground"; }

  test::TemporaryFolder folder_;
};

TEST_F(ExportsOfAFlight, GdalFindsTheGroundAtItsPlaceOnMars) {
  ILP_NEED_TOOL("gdalinfo");
  std::ostringstream messages;
  const report::Report report = ground::run_ground(anchored("{}"), messages);
  for (const char* name : {"height.tif", "count.tif", "ortho.tif"}) {
    const auto found = run_tool("gdalinfo -json -stats " + quoted(out() / name));
    ASSERT_EQ(found.status, 0) << found.output;
    const json info = json::parse(found.output);
    EXPECT_NE(info.at("coordinateSystem").at("wkt").get<std::string>().find("Mars (2015) - Sphere"), std::string::npos);
    EXPECT_TRUE(info.at("bands").at(0).at("metadata").at("").contains("STATISTICS_MEAN")) << name;
    EXPECT_FALSE(fs::exists(out() / (name + std::string(".aux.xml")))) << "they stand in the file itself";
  }
  const double degree = 3396190 * std::numbers::pi / 180;
  for (const auto& [x, y] : {std::pair(0.0, 0.0), std::pair(3.0, 1.0), std::pair(6.0, -1.0)}) {
    std::ostringstream command;
    command.precision(12);
    command << "gdallocationinfo -valonly -l_srs IAU_2015:49900 " << quoted(out() / "height.tif") << " "
            << 10 + 2 * x / (degree * std::cos(20 * std::numbers::pi / 180)) << " " << 20 + 2 * y / degree;
    const auto found = run_tool(command.str());
    ASSERT_EQ(found.status, 0) << found.output;
    EXPECT_NEAR(std::stod(found.output), -2000 + 2 * test::plane_height(x, y), 0.05) << command.str();
  }
  EXPECT_NE(report.strips.at(0).place.find("is on Mars"), std::string::npos) << "the report says which body it is";
}

TEST_F(ExportsOfAFlight, TrackFootprintsAndTablesHaveEveryKeyframe) {
  ILP_NEED_TOOL("ogrinfo");
  std::ostringstream messages;
  (void)ground::run_ground(anchored("{}"), messages);
  const std::size_t keyframes = test::make_flight(false).views.size();
  const auto count = [&](const char* name) { return run_tool("ogrinfo -ro -al -so " + quoted(out() / name)).output; };
  EXPECT_NE(count("track.geojson").find("Feature Count: " + std::to_string(keyframes + 1)), std::string::npos);
  EXPECT_NE(count("footprints.geojson").find("Feature Count: " + std::to_string(keyframes)), std::string::npos);
  EXPECT_NE(count("keyframes.csv").find("Feature Count: " + std::to_string(keyframes)), std::string::npos);
  EXPECT_NE(count("footprints.geojson").find("3396190"), std::string::npos) << count("footprints.geojson");
  for (const char* name : {"model.glb", "points.ply", "events.csv"}) EXPECT_TRUE(fs::exists(out() / name)) << name;
}

TEST_F(ExportsOfAFlight, AnAnchorOnAnotherBodyIsRefusedBeforeAnythingIsWritten) {
  std::ostringstream messages;
  const ground::GroundOptions options = anchored(R"({"source": "simulated world, scenario titan-shore, seed 1"})");
  EXPECT_TRUE(test::says(test::error_of([&] { (void)ground::run_ground(options, messages); }),
                         "on Mars, but the flight was over Titan"));
  EXPECT_FALSE(fs::exists(out()));
}

}  // namespace
}  // namespace ilp::exports
