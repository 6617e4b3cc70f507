// Shapes, tables and point clouds as other programs read them.
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "fsw/base/status.hpp"
#include "sim/ground/export/colmap_model.hpp"
#include "sim/ground/export/flight_tables.hpp"
#include "sim/ground/export/footprint.hpp"
#include "sim/ground/export/point_cloud.hpp"
#include "sim/ground/export/track_export.hpp"
#include "sim/host/files.hpp"
#include "tests/unit/ground/export/strip_of_poses.hpp"
#include "tests/unit/ground/export/tool.hpp"
#include "tests/unit/ground/synthetic_flight.hpp"

namespace ilp::exports {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;
using test::quoted;
using test::run_tool;

std::string text_of(const fs::path& path) {
  const auto bytes = host::read_file(path);
  return {bytes.begin(), bytes.end()};
}

// CSV as RFC 4180 describes it.
std::vector<std::vector<std::string>> read_csv(const fs::path& path) {
  std::vector<std::vector<std::string>> rows(1, std::vector<std::string>(1));
  bool inside = false;
  const std::string text = text_of(path);
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (inside && c == '"' && i + 1 < text.size() && text[i + 1] == '"') {
      rows.back().back() += '"';
      ++i;
    } else if (c == '"') {
      inside = !inside;
    } else if (!inside && c == ',') {
      rows.back().emplace_back();
    } else if (!inside && c == '\n') {
      rows.emplace_back(1);
    } else {
      rows.back().back() += c;
    }
  }
  EXPECT_FALSE(inside);
  rows.pop_back();
  return rows;
}

std::size_t column(const std::vector<std::vector<std::string>>& rows, const std::string& name) {
  const auto& names = rows.at(0);
  const auto found = std::find(names.begin(), names.end(), name);
  EXPECT_NE(found, names.end()) << name;
  return static_cast<std::size_t>(found - names.begin());
}

class TableTest : public ::testing::Test {
 protected:
  test::TemporaryFolder folder_;
};

TEST_F(TableTest, EveryCharacterComesBack) {
  Table table;
  table.columns = {{"id", ColumnType::integer}, {"value", ColumnType::real}, {"text, with comma", ColumnType::text}};
  const std::vector<std::string> texts = {"plain",
                                          "comma, here",
                                          "a \"quoted\" word",
                                          "two\nlines",
                                          "\xC3\x9C"
                                          "ber \xE2\x82\xAC",
                                          "",
                                          " blank ",
                                          "007",
                                          "=1+1"};
  for (std::size_t i = 0; i < texts.size(); ++i) {
    table.rows.push_back({static_cast<std::int64_t>(i), 0.1 * static_cast<double>(i), texts[i]});
  }
  table.rows.push_back({std::monostate(), std::nan(""), std::monostate()});
  write_csv(table, folder_.path() / "table.csv");
  const auto rows = read_csv(folder_.path() / "table.csv");
  ASSERT_EQ(rows.size(), texts.size() + 2);
  EXPECT_EQ(rows[0], (std::vector<std::string>{"id", "value", "text, with comma"}));
  for (std::size_t i = 0; i < texts.size(); ++i) {
    EXPECT_EQ(rows[i + 1][0], std::to_string(i));
    EXPECT_DOUBLE_EQ(std::stod(rows[i + 1][1]), 0.1 * static_cast<double>(i));
    EXPECT_EQ(rows[i + 1][2], texts[i]);
  }
  EXPECT_EQ(rows.back(), (std::vector<std::string>{"", "", ""}));
}

TEST_F(TableTest, WritingOverAnEarlierFileReplacesItAndLeavesNothingElse) {
  Table table{{{"id", ColumnType::integer}, {"name", ColumnType::text}},
              {{std::int64_t{1}, std::string("a")}, {std::int64_t{2}, std::string("b")}}};
  write_csv(table, folder_.path() / "table.csv");
  table.rows.resize(1);
  write_csv(table, folder_.path() / "table.csv");
  EXPECT_EQ(text_of(folder_.path() / "table.csv"), "id,name\n1,a\n");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator()), 1);
}

TEST_F(TableTest, WhatTheVehicleMeasuredIsATable) {
  intake::Flight flight = test::strip_of_poses(true);
  NavigationRecord measured{.id = flight.keyframes.begin()->first, .height_m = 120.5};
  flight.keyframes.begin()->second.navigation = measured;
  StripFrameRecord frame{.id = flight.strips.begin()->first, .metres_per_unit = 3.25, .scale_sigma = 0.001};
  flight.strips.begin()->second.frame = frame;
  const auto names = write_flight_tables(flight, {}, folder_.path());
  EXPECT_EQ(names, (std::vector<std::string>{"keyframes.csv", "events.csv", "navigation.csv", "strip-frames.csv"}));
  auto rows = read_csv(folder_.path() / "navigation.csv");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[1][column(rows, "height_m")], "120.5");
  rows = read_csv(folder_.path() / "strip-frames.csv");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[1][column(rows, "metres_per_unit")], "3.25");
  EXPECT_EQ(rows[1][column(rows, "scale_sigma")], "0.001");
}

TEST_F(TableTest, EventsComeWithTheirMeaningAndAdvice) {
  intake::Flight flight = test::strip_of_poses(true);
  EventRecord event;
  event.id = 4;
  event.time_ns = 12'500'000'000;
  event.code = static_cast<std::uint16_t>(StatusCode::strip_broken);
  event.severity = static_cast<std::uint8_t>(Severity::medium);
  std::strcpy(event.component, "overlap_checker");
  flight.events.push_back(event);
  const auto names = write_flight_tables(flight, {}, folder_.path());
  EXPECT_EQ(names, (std::vector<std::string>{"keyframes.csv", "events.csv"})) << "no housekeeping came";
  const auto rows = read_csv(folder_.path() / "events.csv");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[1][column(rows, "time_s")], "12.5");
  EXPECT_EQ(rows[1][column(rows, "component")], "overlap_checker");
  EXPECT_EQ(rows[1][column(rows, "name")], status_name(StatusCode::strip_broken));
  EXPECT_EQ(rows[1][column(rows, "severity")], "medium");
  EXPECT_EQ(rows[1][column(rows, "advice")], status_advice(StatusCode::strip_broken));
}

TEST_F(TableTest, HousekeepingHasEveryFieldOfItsRecords) {
  intake::Flight flight = test::strip_of_poses(true);
  flight.components.resize(2);
  flight.components[1].id = 2;
  std::strcpy(flight.components[1].name, "downlink");
  flight.components[1].busy_ns = 123456789012345;
  flight.timing.emplace();
  flight.timing->late[3] = 77;
  flight.storage.emplace();
  flight.storage->budget_bytes = 5000000000;
  EXPECT_EQ(write_flight_tables(flight, {}, folder_.path()).size(), 5U);
  const auto components = read_csv(folder_.path() / "housekeeping-components.csv");
  EXPECT_EQ(components.at(2)[column(components, "name")], "downlink");
  EXPECT_EQ(components.at(2)[column(components, "busy_ns")], "123456789012345");
  const auto timing = read_csv(folder_.path() / "housekeeping-timing.csv");
  EXPECT_EQ(timing.at(1)[column(timing, "late_3")], "77");
  const auto storage = read_csv(folder_.path() / "housekeeping-storage.csv");
  EXPECT_EQ(storage.at(1)[column(storage, "budget_bytes")], "5000000000");
}

TEST_F(TableTest, KeyframesHaveTheirPlaceStateAndProducts) {
  intake::Flight flight = test::strip_of_poses(true);
  flight.keyframes.at(2).pose->state = PoseState::failed;
  intake::ProductAccount image{.bytes = 4321};
  flight.keyframes.at(3).products[static_cast<std::size_t>(ProductKind::image)] = image;
  write_csv(keyframe_table(flight, {}), folder_.path() / "keyframes.csv");
  const auto rows = read_csv(folder_.path() / "keyframes.csv");
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[1][column(rows, "state")], "posed");
  EXPECT_EQ(rows[2][column(rows, "state")].rfind("no pose: ", 0), 0U);
  EXPECT_EQ(rows[2][column(rows, "x")], "");
  EXPECT_EQ(rows[3][column(rows, "x")], "16");
  EXPECT_EQ(rows[3][column(rows, "sigma_z")], "0.25");
  EXPECT_EQ(rows[3][column(rows, "products")], "image");
  EXPECT_EQ(rows[3][column(rows, "image_bytes")], "4321");
  EXPECT_EQ(rows[3][column(rows, "unit")], "m");
}

class ShapeTest : public ::testing::Test {
 protected:
  [[nodiscard]] json track(const char* body, double longitude, double latitude) const {
    const intake::Flight flight = test::strip_of_poses(true);
    const Anchors anchors{find_body(body ? body : "mars"), {{1, 1, longitude, latitude, 100, 0, std::nullopt}}};
    const Georeference place = georeference_of(flight, flight.strips.at(1), body ? &anchors : nullptr);
    EXPECT_TRUE(write_track(flight, flight.strips.at(1), place, "", folder_.path()));
    return json::parse(text_of(folder_.path() / "track.geojson"));
  }

  test::TemporaryFolder folder_;
};

TEST_F(ShapeTest, ATrackWithoutAnAnchorIsInTheStripsAxesAndSaysSo) {
  const json found = track(nullptr, 0, 0);
  EXPECT_EQ(found.at("type"), "FeatureCollection");
  EXPECT_EQ(found.at("crs").at("properties").at("name").get<std::string>().find("ENGCRS["), 0U);
  EXPECT_NE(found.at("description").get<std::string>().find("not longitude and latitude"), std::string::npos);
  ASSERT_EQ(found.at("features").size(), 4U);
  EXPECT_EQ(found["features"][0]["geometry"]["type"], "LineString");
  EXPECT_EQ(found["features"][0]["geometry"]["coordinates"],
            json({{0.0, 2.0, 10.0}, {8.0, 2.0, 10.0}, {16.0, 2.0, 10.0}}));
  const json& last = found["features"][3];
  EXPECT_EQ(last["geometry"], json({{"type", "Point"}, {"coordinates", {16.0, 2.0, 10.0}}}));
  EXPECT_EQ(last["properties"]["keyframe"], 3);
  EXPECT_EQ(last["properties"]["sigma_x"], 0.25);
  EXPECT_TRUE(last["properties"]["richness"].is_null());
}

TEST_F(ShapeTest, ATrackOnABodyIsInItsLongitudeAndLatitude) {
  const json found = track("mars", 137.4, -4.6);
  const double degree = 3396190 * std::numbers::pi / 180;
  const json& last = found["features"][3]["geometry"]["coordinates"];
  EXPECT_NEAR(last[0], 137.4 + 16 / (degree * std::cos(4.6 * std::numbers::pi / 180)), 1e-8);
  EXPECT_NEAR(last[1], -4.6, 1e-8);
  EXPECT_EQ(last[2], 100.0);
  EXPECT_NE(found.at("description").get<std::string>().find("Mars"), std::string::npos);
  EXPECT_NE(found.at("crs").dump().find("49900"), std::string::npos) << found.at("crs");
}

TEST_F(ShapeTest, OnTheEarthItIsAsTheStandardWantsIt) {
  const json found = track("earth", 8.5, 47.4);
  EXPECT_FALSE(found.contains("crs")) << "RFC 7946 knows WGS 84 only";
  EXPECT_NEAR(found["features"][1]["geometry"]["coordinates"][0], 8.5, 1e-7);
  EXPECT_NEAR(found["features"][1]["geometry"]["coordinates"][1], 47.4, 1e-7);
}

TEST_F(ShapeTest, OgrinfoReadsTracksAndFootprints) {
  ILP_NEED_TOOL("ogrinfo");
  (void)track("titan", -170, 60);
  const auto result = run_tool("ogrinfo -al -so " + quoted(folder_.path() / "track.geojson"));
  EXPECT_EQ(result.status, 0);
  EXPECT_NE(result.output.find("Feature Count: 4"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("2575000"), std::string::npos) << result.output;
}

TEST_F(ShapeTest, OgrinfoTakesStripUnitsForNoDegrees) {
  ILP_NEED_TOOL("ogrinfo");
  (void)track(nullptr, 0, 0);
  const auto result = run_tool("ogrinfo -al -so " + quoted(folder_.path() / "track.geojson"));
  EXPECT_EQ(result.status, 0);
  EXPECT_EQ(result.output.find("WGS 84"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("Strip 1, local axes"), std::string::npos) << result.output;
}

TEST_F(ShapeTest, AFootprintIsTheGroundUnderTheImagesBorderAndRunsCounterClockwise) {
  const intake::Flight flight = test::strip_of_poses(true);
  CameraModel camera{640, 480, 500, 500, 319.5, 239.5};
  Pose pose;
  // Straight down: the camera's x is the world's, its y the world's -y.
  pose.q_cam_from_world[0] = 0;
  pose.q_cam_from_world[1] = 1;
  pose.centre[0] = 8;
  pose.centre[1] = 2;
  pose.centre[2] = 10;
  const std::vector<Vec3> outline = footprint(camera, pose, {0, 0, 1}, [](double, double) { return 1.0; });
  ASSERT_EQ(outline.size(), 24U);
  // 8 above the ground at 2: half of 640 px at 500 px.
  EXPECT_LT((outline[0] - Vec3(8 - 8 * 0.64, 2 + 8 * 0.48, 2)).norm(), 1e-9);
  EXPECT_LT((outline[12] - Vec3(8 + 8 * 0.64, 2 - 8 * 0.48, 2)).norm(), 1e-9);
  const Georeference place = georeference_of(flight, flight.strips.at(1), nullptr);
  ASSERT_TRUE(
      write_footprints(flight, flight.strips.at(1), {{2, outline}, {3, {}}}, place, "-strip-1", folder_.path()));
  const json found = json::parse(text_of(folder_.path() / "footprints-strip-1.geojson"));
  ASSERT_EQ(found.at("features").size(), 1U);
  EXPECT_EQ(found["features"][0]["properties"]["keyframe"], 2);
  const json& ring = found["features"][0]["geometry"]["coordinates"][0];
  ASSERT_EQ(ring.size(), 25U);
  EXPECT_EQ(ring.front(), ring.back());
  double area = 0;
  for (std::size_t i = 0; i + 1 < ring.size(); ++i) {
    area += ring[i][0].get<double>() * ring[i + 1][1].get<double>() -
            ring[i + 1][0].get<double>() * ring[i][1].get<double>();
  }
  EXPECT_NEAR(area / 2, 64 * 1.28 * 0.96, 1e-3);
}

TEST_F(ShapeTest, AStripWithoutPosesHasNoTrack) {
  intake::Flight flight = test::strip_of_poses(true);
  for (auto& [id, keyframe] : flight.keyframes) keyframe.pose.reset();
  const Georeference place = georeference_of(flight, flight.strips.at(1), nullptr);
  EXPECT_FALSE(write_track(flight, flight.strips.at(1), place, "", folder_.path()));
  EXPECT_FALSE(fs::exists(folder_.path() / "track.geojson"));
}

class PointsOfAFlight : public ::testing::Test {
 protected:
  void SetUp() override {
    made_ = test::make_flight(false);
    test::write_outbox(made_, folder_.path() / "outbox");
    intake::Outbox outbox = intake::read_outbox(folder_.path() / "outbox");
    flight_ = intake::build_flight(outbox);
  }

  test::TemporaryFolder folder_;
  test::SyntheticFlight made_;
  intake::Flight flight_;
};

TEST_F(PointsOfAFlight, APointCloudHasEveryPointWithItsGreyValueAndError) {
  const intake::Strip& strip = flight_.strips.at(1);
  const Georeference place = georeference_of(flight_, strip, nullptr);
  const auto grey = [](std::int64_t, double x, double) {
    return x >= 0 ? std::optional<std::uint8_t>(static_cast<std::uint8_t>(200)) : std::nullopt;
  };
  const std::vector<std::uint8_t> file = point_cloud_ply(flight_, strip, place, grey);
  const std::string text(file.begin(), file.end());
  EXPECT_NE(text.find("element vertex " + std::to_string(made_.points.size()) + "\n"), std::string::npos);
  const std::size_t body = text.find("end_header\n") + 11;
  constexpr std::size_t record = 3 * 8 + 3 + 4 + 4;
  ASSERT_EQ(file.size(), body + made_.points.size() * record);
  for (std::size_t i = 0; i < made_.points.size(); ++i) {
    double position[3];
    float error = 0;
    std::memcpy(position, file.data() + body + i * record, sizeof(position));
    std::memcpy(&error, file.data() + body + i * record + 27, sizeof(error));
    EXPECT_LT((Vec3(position[0], position[1], position[2]) - made_.points[i]).norm(), 1e-9);
    EXPECT_EQ(file[body + i * record + 24], 200);
    EXPECT_EQ(error, 0.1F);
  }
}

TEST_F(PointsOfAFlight, ColmapReadsTheModel) {
  const ColmapCounts counts = write_colmap_model(flight_, flight_.strips.at(1), folder_.path() / "colmap");
  ILP_NEED_TOOL("colmap");
  const auto result =
      run_tool("QT_QPA_PLATFORM=offscreen colmap model_analyzer --path " + quoted(folder_.path() / "colmap") + " 2>&1");
  ASSERT_EQ(result.status, 0) << result.output;
  for (const auto& [name, count] : {std::pair("Registered images: ", counts.images),
                                    {"Points: ", counts.points},
                                    {"Observations: ", counts.observations}}) {
    EXPECT_NE(result.output.find(name + std::to_string(count)), std::string::npos) << name << "\n" << result.output;
  }
}

}  // namespace
}  // namespace ilp::exports
