// What the ground says of the fixes of a flight, over strips whose true places are known.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "fsw/maps/map_tile.hpp"
#include "fsw/shared/local_plane.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/ground/fixes/fix_text.hpp"
#include "sim/ground/fixes/map_image.hpp"
#include "sim/ground/ground_run.hpp"
#include "sim/ground/intake/move_keyframe.hpp"
#include "tests/support/page_text.hpp"
#include "tests/unit/ground/synthetic_flight.hpp"

namespace ilp::fixes {
namespace {

namespace fs = std::filesystem;

constexpr double height_m = 100, unit_m = 4;
const BodyPlace origin{137.4, -4.6, 0};
const Vec3 strip_axes(0.1, -0.2, 0.7);
const Vec3 strip_origin(300, -80, 20);

Mat3 down() {
  return Vec3(1, -1, -1).asDiagonal();
}

/// Looks straight down from there; level ground at 0.
FixRecord fix_at(std::int64_t id, const Vec3& centre) {
  FixRecord fix{.id = id, .strip_id = 1};
  // A digest: any 64 bits.
  fix.map_id = static_cast<std::int64_t>(0xf8452fde5f3b02ba);
  fix.state = FixState::accepted;
  fix.verdict = MapVerdict::fixed;
  fix.prior = FixPrior::fixes;
  fix.pixel_m = 1;
  fix.evidence = 40;
  fix.patches = 30;
  fix.votes = 20;
  fix.body = Body::mars;
  fix.map_longitude_deg = origin.longitude_deg;
  fix.map_latitude_deg = origin.latitude_deg;
  fix.ground_m[0] = fix.centre_m[0] = centre.x();
  fix.ground_m[1] = fix.centre_m[1] = centre.y();
  fix.centre_m[2] = centre.z();
  fix.ground_covariance[0] = fix.ground_covariance[2] = 0.01;
  fix.ground_height_sigma_m = 0.1;
  fix.ground_depth = height_m / unit_m;
  fix.ground_depth_sigma = 0.01 * fix.ground_depth;
  quaternion_from_rotation(down(), fix.q_cam_from_map);
  for (int i = 0, k = 0; i < 6; ++i) {
    for (int j = 0; j <= i; ++j, ++k) fix.covariance[k] = i != j ? 0 : i < 3 ? 1e-6 : 0.04;
  }
  return fix;
}

/// The camera's pose in the strip's world, which is turned, moved, and has units of 4 m.
PoseRecord pose_at(std::int64_t id, const Vec3& centre) {
  const Mat3 level_from_strip = rotation_from_vector(strip_axes);
  PoseRecord pose{.id = id, .strip_id = 1, .state = PoseState::final};
  quaternion_from_rotation(down() * level_from_strip, pose.q_cam_from_world);
  const Vec3 in_strip = level_from_strip.transpose() * (centre - strip_origin) / unit_m;
  std::copy_n(in_strip.data(), 3, pose.centre);
  pose.ground_distance = height_m / unit_m;
  pose.ground_distance_sigma = 0.01 * pose.ground_distance;
  return pose;
}

Vec3 centre_of(std::int64_t id) {
  return {25.0 * static_cast<double>(id), 5.0 * static_cast<double>(id), height_m};
}

/// Poses are off by `step` from keyframe 13 on.
intake::Flight strip_of(std::int64_t count, const Vec3& step) {
  intake::Flight flight;
  for (std::int64_t id = 1; id <= count; ++id) {
    intake::Keyframe& keyframe = flight.keyframes[id];
    keyframe.id = id;
    keyframe.strip_id = 1;
    keyframe.pose = pose_at(id, centre_of(id) + (id > 12 ? step : Vec3::Zero()));
    keyframe.fix = fix_at(id, centre_of(id));
    flight.strips[1].keyframes.push_back(id);
  }
  flight.strips[1].id = 1;
  return flight;
}

TEST(FixesOfFlight, AStepOfThePosesIsWhatTheFixesRemoved) {
  const FixSummary summary = fixes_of(strip_of(20, Vec3(-6, 30, 0)));
  ASSERT_EQ(summary.strips.size(), 1U);
  const StripFixes& strip = summary.strips[0];
  EXPECT_EQ(strip.accepted, 20U);
  const double step = std::hypot(6, 30);
  for (const KeyframeFix& one : strip.keyframes) {
    ASSERT_TRUE(one.off_by_first_m.has_value());
    EXPECT_NEAR(*one.off_by_first_m, one.fix.id > 12 ? step : 0, 0.05) << one.fix.id;
    EXPECT_FALSE(one.off_by_vehicle_m.has_value()) << "the vehicle measured nothing";
  }
  EXPECT_EQ(strip.off_by_first.count, 12U) << "of the fixes after the first eight";
  EXPECT_NEAR(strip.off_by_first.max, step, 0.05);
  // The camera's track stands where the fixes are.
  ASSERT_EQ(strip.track_by_first.size(), 20U);
  EXPECT_NEAR((strip.track_by_first[5] - centre_of(6)).norm(), 0, 0.1);
  EXPECT_NEAR((strip.track_by_first[19] - centre_of(20)).head<2>().norm(), step, 0.1);
}

/// It stands in another unit then, and nothing changes.
TEST(FixesOfFlight, AStripThatWasMovedSaysTheSame) {
  intake::Flight flight = strip_of(20, Vec3(-6, 30, 0));
  Similarity by;
  by.scale = unit_m;
  by.rotation = rotation_from_vector(Vec3(0.3, 0.1, -1));
  by.translation = Vec3(5, 6, 7);
  for (auto& [id, keyframe] : flight.keyframes) intake::move(by, keyframe);
  EXPECT_NEAR(flight.keyframes[3].fix->ground_depth, height_m, 1e-9);
  EXPECT_NEAR(fixes_of(flight).strips[0].off_by_first.max, std::hypot(6, 30), 0.05);
}

TEST(FixesOfFlight, AVehicleThatIsOffIsSaidToBeOff) {
  intake::Flight flight = strip_of(16, Vec3::Zero());
  for (auto& [id, keyframe] : flight.keyframes) {
    NavigationRecord measured{.id = id};
    const double place[3] = {centre_of(id).x() + 40, centre_of(id).y() - 30, height_m};
    const BodyPlace at = place_from_plane(Body::mars, origin, place);
    measured.longitude_deg = at.longitude_deg;
    measured.latitude_deg = at.latitude_deg;
    measured.elevation_m = height_m;
    measured.horizontal_sigma_m = measured.vertical_sigma_m = 5;
    measured.height_m = height_m;
    measured.height_sigma_m = 1;
    quaternion_from_rotation(down(), measured.q_cam_from_level);
    measured.tilt_sigma_rad = measured.heading_sigma_rad = 0.01;
    keyframe.navigation = measured;
  }
  const StripFixes strip = fixes_of(flight).strips[0];
  EXPECT_EQ(strip.off_by_vehicle.count, 16U);
  EXPECT_NEAR(strip.off_by_vehicle.median, 50, 0.5);
  EXPECT_LT(strip.off_by_all.max, 0.05);
}

TEST(FixesOfFlight, TheEllipseHasTheSigmasOfItsAxes) {
  // 3 m along 30 degrees, 1 m across.
  const double c = std::cos(0.5235987755982988), s = 0.5;
  FixRecord fix;
  fix.ground_covariance[0] = 9 * c * c + s * s;
  fix.ground_covariance[1] = 8 * s * c;
  fix.ground_covariance[2] = 9 * s * s + c * c;
  const ErrorEllipse ellipse = ellipse_of(fix);
  EXPECT_NEAR(ellipse.major_m, 3, 1e-9);
  EXPECT_NEAR(ellipse.minor_m, 1, 1e-9);
  EXPECT_NEAR(ellipse.direction_rad, 0.5235987755982988, 1e-9);
}

// Reports.

struct Reported {
  test::TemporaryFolder folder;
  std::string page;  ///< empty without node
  nlohmann::json json;
  std::vector<std::string> lines;

  explicit Reported(const std::vector<FixRecord>& fixes, const fs::path& map = {}) {
    const fs::path outbox = folder.path() / "outbox";
    test::write_outbox(test::make_flight(false), outbox);
    std::vector<intake::RecordEntry> entries;
    for (const FixRecord& fix : fixes) entries.push_back(intake::entry_of(fix, {{}}));
    const std::vector<std::uint8_t> bytes = intake::write_record_file(entries);
    if (!fixes.empty()) {
      std::ofstream(outbox / "records-000099.ilp", std::ios::binary)
          .write(reinterpret_cast<const char*>(bytes.data()), std::ssize(bytes));
    }
    ground::GroundOptions options{.outbox = outbox, .out = folder.path() / "out", .map = map};
    std::ostringstream messages;
    lines = ground::summary_of(options, ground::run_ground(options, messages));
    if (test::have_tool("node")) page = test::page_text(options.out / "report.html");
    std::ifstream report(options.out / "report.json");
    json = nlohmann::json::parse(report);
  }
  [[nodiscard]] bool says(const std::string& text) const {
    return std::any_of(lines.begin(), lines.end(), [&](const std::string& l) { return l.find(text) != l.npos; });
  }
};

TEST(FixesOfFlight, TheReportHasFixesWithPlaceAndErrorAndTheReasonsOfTheOthers) {
  std::vector<FixRecord> fixes;
  for (std::int64_t id = 1; id <= 5; ++id) fixes.push_back(fix_at(id, centre_of(id)));
  fixes[3].verdict = fixes[4].verdict = MapVerdict::no_agreement;
  fixes[3].state = fixes[4].state = FixState::none;
  fixes[2].sense = MapSense::shape;
  const Reported reported(fixes);
  const auto& all = reported.json.at("fixes");
  EXPECT_EQ(all.at("fixed"), 3);
  EXPECT_EQ(all.at("accepted"), 3);
  EXPECT_EQ(all.at("verdicts").at("no_agreement"), 2);
  EXPECT_EQ(all.at("senses").at("shape"), 1);
  const auto& strip = all.at("strips").at(0);
  EXPECT_EQ(strip.at("map"), "f8452fde5f3b02ba");
  EXPECT_NEAR(strip.at("keyframes").at(1).at("ground_m").at(0).get<double>(), 50, 1e-12);
  EXPECT_NEAR(strip.at("keyframes").at(1).at("sigma_major_m").get<double>(), 0.1, 1e-12);
  EXPECT_TRUE(reported.says("3 of 5 keyframes fixed on map f8452fde5f3b02ba"));
  EXPECT_TRUE(reported.says("2 no_agreement (too few pieces of the keyframe agree on one place)"));
  ILP_NEED_TOOL("node");
  EXPECT_NE(reported.page.find("<h2>Place on the map</h2>"), std::string::npos);
  const std::size_t begin = reported.page.find("<h2>Place on the map</h2>");
  const std::string section = reported.page.substr(begin, reported.page.find("<h2>", begin + 4) - begin);
  EXPECT_EQ(section.find("nan"), std::string::npos);
  const auto crosses = [&](const char* colour) {
    std::size_t count = 0;
    const std::string mark = "<g stroke=\"" + std::string(colour);
    for (std::size_t at = section.find(mark); at != section.npos; at = section.find(mark, at + 1)) ++count;
    return count;
  };
  EXPECT_EQ(crosses("#58b06a"), 3U) << "accepted";
  EXPECT_EQ(crosses("#e08a3c"), 0U) << "not confirmed";
  EXPECT_EQ(section.find("<image"), std::string::npos) << "no map is at hand";
}

/// Its image is bright in the east, and its south is not known.
void write_map_of_halves(const fs::path& folder) {
  fs::create_directories(folder);
  MapDirectory directory{.id = 0xf8452fde5f3b02ba, .body = Body::mars, .sun_elevation_rad = 0.5, .layer_count = 1};
  directory.layers[0] = {1, -256, 256, 2, 2};
  const auto workspace = std::make_unique<MapTileWorkspace>();
  for (std::uint16_t column = 0; column < 2; ++column) {
    const auto tile = std::make_unique<MapTile>();
    tile->column = column;
    tile->image.fill(column == 0 ? 60 : 180);
    tile->posts.fill(0);
    std::vector<std::uint8_t> file(limits::max_map_tile_bytes);
    std::size_t size = 0;
    ASSERT_TRUE(encode_map_tile(*tile, {}, directory.id, {}, *workspace, file, size).ok());
    file.resize(size);
    (void)directory.tiles.push_back(
        {map_tile_digest(directory.id, file), static_cast<std::uint16_t>(size), 0, 0, column});
    std::ofstream(folder / map_tile_name({0, 0, column}).c_str(), std::ios::binary)
        .write(reinterpret_cast<const char*>(file.data()), std::ssize(file));
  }
  std::vector<std::uint8_t> bytes(max_map_directory_bytes);
  std::size_t size = 0;
  ASSERT_TRUE(write_map_directory(directory, {}, bytes, size).ok());
  std::ofstream(folder / map_directory_name, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(size));
}

TEST(FixesOfFlight, ThePictureOfTheMapHasItsGroundInPlace) {
  const test::TemporaryFolder folder;
  write_map_of_halves(folder / "map");
  MapImage image(folder / "map");
  // From 30 m west of the middle and 20 m north of it, half a metre a pixel.
  const host::Raster<std::uint8_t> picture = image.picture(-30, 20, 0.5, 100, 60);
  for (std::int32_t row = 0; row < 60; ++row) {
    for (std::int32_t column = 0; column < 100; ++column) {
      const int wanted = row >= 40 ? 0 : column < 60 ? 60 : 180;
      ASSERT_NEAR(picture.at(column, row), wanted, wanted == 0 ? 0 : 2) << column << ", " << row;
    }
  }
  fs::remove(folder.path() / "map" / "tile-0-0000-0001.ilpt");
  EXPECT_EQ(image.picture(-30, 20, 0.5, 100, 60).at(80, 10), 0) << "a tile that is missing";
}

TEST(FixesOfFlight, TheReportShowsTheMapThatTheFlightCarriedAndNoOther) {
  ILP_NEED_TOOL("node");
  const test::TemporaryFolder folder;
  write_map_of_halves(folder / "map");
  std::vector<FixRecord> fixes;
  for (std::int64_t id = 1; id <= 5; ++id) fixes.push_back(fix_at(id, centre_of(id)));
  fixes[4].state = FixState::unconfirmed;
  const auto section_of = [](const std::string& page) {
    const std::size_t begin = page.find("<h2>Place on the map</h2>");
    return page.substr(begin, page.find("<h2>", begin + 4) - begin);
  };
  const std::string own = section_of(Reported(fixes, folder / "map").page);
  EXPECT_NE(own.find("<image width=\"1200\""), std::string::npos);
  EXPECT_NE(own.find("<g stroke=\"#e08a3c"), std::string::npos) << "one was not confirmed";
  for (FixRecord& fix : fixes) fix.map_id = 17;
  const std::string other = section_of(Reported(fixes, folder / "map").page);
  EXPECT_EQ(other.find("<image"), std::string::npos);
  EXPECT_NE(other.find("is another one (f8452fde5f3b02ba)"), std::string::npos);
  EXPECT_THROW(Reported(fixes, folder / "nothing"), std::runtime_error);
}

TEST(FixesOfFlight, AFlightWhoseMapGaveNoFixSaysWhy) {
  std::vector<FixRecord> fixes(3);
  for (std::int64_t id = 1; id <= 3; ++id) {
    fixes[static_cast<std::size_t>(id - 1)].id = id;
    fixes[static_cast<std::size_t>(id - 1)].strip_id = 1;
  }
  const Reported reported(fixes);
  EXPECT_EQ(reported.json.at("fixes").at("fixed"), 0);
  EXPECT_TRUE(reported.says("No map could be used"));
  EXPECT_TRUE(reported.says("Without a fix: 3 no_map"));
  EXPECT_EQ(reported.page.find("<ellipse"), std::string::npos);
}

TEST(FixesOfFlight, AFlightWithoutAMapHasNothingOfIt) {
  const Reported reported({});
  EXPECT_FALSE(reported.json.contains("fixes"));
  EXPECT_EQ(reported.page.find("Place on the map"), std::string::npos);
}

TEST(FixesOfFlight, HostileFixesAreLeftOutAndNamed) {
  std::vector<FixRecord> fixes;
  for (std::int64_t id = 1; id <= 6; ++id) fixes.push_back(fix_at(id, centre_of(id)));
  fixes[0].ground_m[1] = std::numeric_limits<double>::quiet_NaN();
  fixes[1].verdict = static_cast<MapVerdict>(77);
  fixes[2].ground_covariance[1] = 5;
  fixes[3].strip_id = 9;
  fixes[5].latitude_deg = 91;
  const Reported reported(fixes);
  EXPECT_EQ(reported.json.at("fixes").at("keyframes"), 1);
  std::string remarks;
  for (const auto& remark : reported.json.at("remarks")) remarks += remark.get<std::string>() + "\n";
  for (const int id : {1, 2, 3, 4, 6})
    EXPECT_NE(remarks.find("the fix of keyframe " + std::to_string(id) + " is left out"), std::string::npos) << remarks;
}

}  // namespace
}  // namespace ilp::fixes
