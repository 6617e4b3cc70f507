// A flight over the map that an orbiter has made of its world: fixes, the strip's place, and restarts.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "fsw/shared/body_figure.hpp"
#include "fsw/shared/local_plane.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/host/reference_cameras.hpp"
#include "tests/integration/flight_files.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

test::ProgramResult fly_over(const fs::path& map, const fs::path& mission, const fs::path& out,
                             const std::vector<std::string>& more) {
  std::vector<std::string> words = {ILP_SIL, "--scenario", "mars-plains", "--map", map.string(), "--out", out.string()};
  if (!mission.empty()) words.insert(words.end(), {"--mission", mission.string()});
  for (const char* setting :
       {"camera.width=320", "camera.height=240", "camera.fx=275", "camera.fy=275", "navigation.altimeter=true",
        "navigation.attitude=true", "navigation.position=true", "navigation.end_s=8"})
    words.insert(words.end(), {"--set", setting});
  words.insert(words.end(), more.begin(), more.end());
  return test::run_program(words);
}

/// The flight, with sensors of its vehicle in its first 8 s only, and the map under another sun. The simulator says
/// where the sun of the flight stands; `mission` says it for others that fly the images.
struct MapFlightFiles {
  test::TemporaryFolder folder;
  fs::path map = folder / "map", out = folder / "flight", mission = folder / "mission.ini";

  MapFlightFiles() {
    test::run_well({ILP_LAB, "world-map", "mars-plains", "--area=-150,-150,400,150", "--pixel", "1.6", "--body", "mars",
                    "--origin", "137.4,-4.6", "--sun-turn", "34", "--features", "0", "--place-sigma", "0.5", "--out",
                    map.string()});
    std::ofstream(mission) << "[map]\nmap_sun_given = true\nmap_sun_azimuth_rad = 2.2\nmap_sun_elevation_rad = 0.55\n";
    const test::ProgramResult flown = fly_over(map, {}, out, {"--frames", "48"});
    EXPECT_EQ(flown.exit_status, 0) << flown.output;
  }
};
/// Flown once for all tests here.
const MapFlightFiles& flown() {
  static const MapFlightFiles files;
  return files;
}

TEST(MapFlight, KeyframesAreFixedToTheirTruePlaces) {
  std::map<std::string, host::ReferenceCamera> truth;
  for (const auto& camera : host::read_reference_cameras(flown().out / "flight" / "truth" / "poses.txt"))
    truth[camera.name] = camera;
  std::map<std::int64_t, std::string> names;
  for (const auto& frame : test::records_of<FrameRecord>(flown().out)) names[frame.id] = frame.name;
  std::map<std::int64_t, std::int64_t> frames;
  for (const auto& keyframe : test::records_of<KeyframeRecord>(flown().out)) frames[keyframe.id] = keyframe.frame_id;

  const auto fixes = test::records_of<FixRecord>(flown().out);
  ASSERT_GE(fixes.size(), 8U);
  std::size_t fixed = 0, placed = 0;
  double squares = 0;
  for (const FixRecord& fix : fixes) {
    const host::ReferenceCamera& camera = truth.at(fs::path(names.at(frames.at(fix.id))).filename().string());
    if (fix.place_sigma_m > 0) {
      const double dx = fix.place_m[0] - camera.centre.x(), dy = fix.place_m[1] - camera.centre.y();
      squares += (dx * dx + dy * dy) / (2 * fix.place_sigma_m * fix.place_sigma_m);
      ++placed;
    }
    if (fix.verdict != MapVerdict::fixed) continue;
    ++fixed;
    EXPECT_EQ(fix.state, FixState::accepted);
    const Vec3 axis = camera.cam_from_world.row(2);
    const Vec3 ground = camera.centre + (fix.ground_m[2] - camera.centre.z()) / axis.z() * axis;
    EXPECT_LT(std::hypot(fix.ground_m[0] - ground.x(), fix.ground_m[1] - ground.y()), fix.pixel_m) << fix.id;
  }
  EXPECT_GE(fixed + 1, fixes.size());
  EXPECT_GE(placed + 1, fixes.size());
  // Fixes over the same ground err together, so that the flight is one draw of two numbers: 1 % are above 4.6.
  EXPECT_LT(squares / static_cast<double>(placed), 4.6) << "the estimated error of the place";

  const auto frame = test::records_of<StripFrameRecord>(flown().out);
  ASSERT_EQ(frame.size(), 1U);
  EXPECT_EQ(frame[0].verdict, StripFrameVerdict::ok);
  EXPECT_GE(frame[0].fixes_used, 8U);
  // The strip's origin is the place of its first camera.
  const host::ReferenceCamera& first = truth.at("0001.pgm");
  double offset[3];
  offset_from(Body::mars, {137.4, -4.6, 0}, {frame[0].longitude_deg, frame[0].latitude_deg, frame[0].elevation_m},
              offset);
  EXPECT_LT(std::hypot(offset[0] - first.centre.x(), offset[1] - first.centre.y()), 2);
  EXPECT_NEAR(offset[2], first.centre.z(), 2);
}

// The wish comes long before the flight is there: it knows by its fixes when it passes.
TEST(MapFlight, AnImageOfAPlaceIsTakenWhereTheFlightPassesIt) {
  const auto cameras = host::read_reference_cameras(flown().out / "flight" / "truth" / "poses.txt");
  ASSERT_EQ(cameras.size(), 48U);
  constexpr double distance_m = 12;
  const auto command = [](const Vec3& place) {
    const double metres[3] = {place.x(), place.y(), 0};
    const BodyPlace at = place_from_plane(Body::mars, {137.4, -4.6, 0}, metres);
    std::ostringstream line;
    line.precision(12);
    line << "30 place " << at.longitude_deg << " " << at.latitude_deg << " " << distance_m << "\n";
    return line.str();
  };
  const Vec3 way = (cameras[40].centre - cameras[38].centre).normalized(), across(-way.y(), way.x(), 0);
  const Vec3 near = cameras[39].centre + 7 * across, far = cameras[39].centre - 40 * across;
  const test::TemporaryFolder folder;
  test::write_file(folder / "commands.txt", command(near) + command(far));
  std::ofstream(folder / "mission.ini") << "[acquisition]\ncapture_mode = forecast\n";
  const fs::path out = folder / "flight";
  ASSERT_EQ(
      fly_over(flown().map, folder / "mission.ini", out, {"--frames", "60", "--telecommands", folder / "commands.txt"})
          .exit_status,
      0);

  std::map<std::string, host::ReferenceCamera> truth;
  for (const auto& camera : host::read_reference_cameras(out / "flight" / "truth" / "poses.txt"))
    truth[camera.name] = camera;
  std::map<std::int64_t, std::string> names;
  for (const auto& frame : test::records_of<FrameRecord>(out)) names[frame.id] = frame.name;
  std::size_t exposed = 0, rejected = 0;
  for (const CaptureRecord& capture : test::records_of<CaptureRecord>(out)) {
    if (capture.command_id == 0) continue;
    rejected += capture.state == CaptureState::rejected ? 1U : 0U;
    if (capture.state != CaptureState::exposed) continue;
    ++exposed;
    const host::ReferenceCamera& camera = truth.at(fs::path(names.at(capture.frame_id)).filename().string());
    EXPECT_LT((camera.centre - near).head<2>().norm(), distance_m) << "the vehicle";
    const Vec3 axis = camera.cam_from_world.row(2);
    const Vec3 middle = camera.centre - camera.centre.z() / axis.z() * axis;
    EXPECT_LT((middle - near).head<2>().norm(), distance_m) << "the middle of the image";
    // A line through two places of 0.6 m each, carried on for twice the way between them: 2 m, three sigmas.
    EXPECT_NEAR(capture.distance_m, (camera.centre - near).head<2>().norm(), 6) << "the forecast";
  }
  EXPECT_EQ(exposed, 1U);
  EXPECT_EQ(rejected, 1U) << "40 m off is not within 12 m";
}

TEST(MapFlight, KillsChangeNothing) {
  const test::TemporaryFolder folder;
  const fs::path images = flown().out / "flight";
  const auto words = [&](const fs::path& out, const std::vector<std::string>& more) {
    std::vector<std::string> all = test::sil_command(images, out.string(), more);
    all.insert(all.end(), {"--navigation", (images / "navigation.csv").string(), "--map", flown().map.string(),
                           "--mission", flown().mission.string()});
    return all;
  };
  const fs::path whole = folder / "whole", killed = folder / "killed";
  ASSERT_EQ(test::run_program(words(whole, {})).exit_status, 0);
  ASSERT_EQ(test::run_program(words(killed, {"--power-cut-after", "300"})).exit_status, 9);
  ASSERT_EQ(test::run_program(words(killed, {"--resume", "--power-cut-after", "250"})).exit_status, 9);
  ASSERT_EQ(test::run_program(words(killed, {"--resume"})).exit_status, 0);
  test::expect_same_files(test::files_of(whole / "outbox", {"product-", "records-", "points-"}),
                          test::files_of(killed / "outbox", {"product-", "records-", "points-"}));
  EXPECT_GE(test::records_of<FixRecord>(whole).size(), 8U);
}

/// On the ground: what came down of the flight, and the same map tried on it afterwards.
TEST(MapFlight, TheGroundHasTheFixesAndFindsThemAgainInWhatCameDown) {
  std::map<std::string, host::ReferenceCamera> truth;
  for (const auto& camera : host::read_reference_cameras(flown().out / "flight" / "truth" / "poses.txt"))
    truth[camera.name] = camera;
  std::map<std::int64_t, std::string> names;
  for (const auto& frame : test::records_of<FrameRecord>(flown().out)) names[frame.id] = frame.name;
  std::map<std::int64_t, host::ReferenceCamera> cameras;
  for (const auto& keyframe : test::records_of<KeyframeRecord>(flown().out))
    cameras[keyframe.id] = truth.at(fs::path(names.at(keyframe.frame_id)).filename().string());

  const test::TemporaryFolder folder;
  const fs::path outbox = flown().out / "outbox", results = folder / "ground", found = folder / "fixes.json";
  const test::ProgramResult reported = test::run_well({ILP_GROUND, outbox.string(), "--out", results.string()});
  EXPECT_EQ(reported.output.find("skipped"), std::string::npos) << reported.output;
  std::ifstream report(results / "report.json");
  const auto in_flight = nlohmann::json::parse(report).at("fixes");
  std::size_t fixed = 0;
  for (const FixRecord& fix : test::records_of<FixRecord>(flown().out)) fixed += fix.verdict == MapVerdict::fixed;
  EXPECT_EQ(in_flight.at("fixed"), fixed);
  EXPECT_LT(in_flight.at("strips").at(0).at("off_by_all_fixes_m").at("median").get<double>(), 1.6);

  test::run_well({ILP_GROUND, "map-check", flown().out.string(), flown().map.string(), "--mission",
                  flown().mission.string(), "--out", found.string()});
  std::ifstream file(found);
  const auto strip = nlohmann::json::parse(file).at("fixes").at("strips").at(0);
  std::size_t again = 0;
  for (const auto& one : strip.at("keyframes")) {
    if (one.at("verdict") != "fixed") continue;
    ++again;
    const host::ReferenceCamera& camera = cameras.at(one.at("keyframe").get<std::int64_t>());
    const std::vector<double> at = one.at("ground_m");
    const Vec3 axis = camera.cam_from_world.row(2);
    const Vec3 ground = camera.centre + (at[2] - camera.centre.z()) / axis.z() * axis;
    const double off = std::hypot(at[0] - ground.x(), at[1] - ground.y());
    EXPECT_LT(off, 4 * one.at("sigma_major_m").get<double>()) << one.at("keyframe");
    EXPECT_LT(off, 2 * one.at("pixel_m").get<double>()) << one.at("keyframe");
  }
  EXPECT_GE(again + 2, fixed);

  // The directory alone.
  const fs::path bare = folder / "bare";
  fs::create_directories(bare);
  fs::copy(flown().map / "directory.ilpm", bare);
  const test::ProgramResult without =
      test::run_well({ILP_GROUND, "map-check", flown().out.string(), bare.string(), "--sun", "10,30"});
  for (const char* part : {"are not in the folder and 0 are damaged", "no_map"})
    EXPECT_NE(without.output.find(part), std::string::npos) << without.output;
  EXPECT_EQ(without.output.find("no_agreement"), std::string::npos) << without.output;

  // Every tile damaged: many keyframes meet each of them.
  const fs::path damaged = folder / "damaged";
  fs::copy(flown().map, damaged, fs::copy_options::recursive);
  for (const auto& tile : fs::directory_iterator(damaged)) {
    if (tile.path().filename() == "directory.ilpm") continue;
    std::fstream file_of_tile(tile.path(), std::ios::in | std::ios::out | std::ios::binary);
    file_of_tile.seekp(40).put('\x5a').put('\xa5');
  }
  const test::ProgramResult hit =
      test::run_well({ILP_GROUND, "map-check", flown().out.string(), damaged.string(), "--sun", "10,30"});
  std::map<std::string, int> times;
  std::istringstream lines(hit.output);
  for (std::string line; std::getline(lines, line);) ++times[line];
  std::size_t named = 0;
  for (const auto& [line, number] : times) {
    EXPECT_EQ(number, 1) << line;
    named += line.find("record_damaged") != std::string::npos;
  }
  EXPECT_GE(named, 1U) << hit.output;

  const test::ProgramResult wrong =
      test::run_program({ILP_GROUND, "map-check", flown().out.string(), folder / "nothing"});
  EXPECT_EQ(wrong.exit_status, 1);
  EXPECT_NE(wrong.output.find("directory.ilpm"), std::string::npos) << wrong.output;
}

/// Exports say where the world is and how far all of it may be off, and a map made of them says the same again.
TEST(MapFlight, TheModelLiesOnTheBodyWhereTheWorldDoes) {
  const test::TemporaryFolder folder;
  const fs::path results = folder / "ground", again = folder / "again";
  test::run_well({ILP_GROUND, (flown().out / "outbox").string(), "--out", results.string()});
  std::ifstream report_file(results / "report.json");
  const auto place = nlohmann::json::parse(report_file).at("strips").at(0).at("place");
  EXPECT_EQ(place.at("body"), "mars");
  EXPECT_EQ(place.at("map_sigma_m"), 0.5);
  const auto sigma_m = place.at("sigma_m").get<double>();
  EXPECT_DOUBLE_EQ(place.at("whole_sigma_m").get<double>(), std::hypot(sigma_m, 0.5));

  std::map<std::string, host::ReferenceCamera> truth;
  for (const auto& camera : host::read_reference_cameras(flown().out / "flight" / "truth" / "poses.txt"))
    truth[camera.name] = camera;
  std::ifstream track_file(results / "track.geojson");
  const auto track = nlohmann::json::parse(track_file);
  std::size_t compared = 0;
  for (const auto& feature : track.at("features")) {
    if (feature.at("geometry").at("type") != "Point") continue;
    const std::vector<double> at = feature.at("geometry").at("coordinates");
    const auto name = feature.at("properties").at("name").get<std::string>();
    double offset[3];
    offset_from(Body::mars, {137.4, -4.6, 0}, {at.at(0), at.at(1), at.at(2)}, offset);
    const Vec3& centre = truth.at(fs::path(name).filename().string()).centre;
    EXPECT_LT(std::hypot(offset[0] - centre.x(), offset[1] - centre.y()), 6 * sigma_m) << name;
    EXPECT_NEAR(offset[2], centre.z(), 2) << name;
    ++compared;
  }
  EXPECT_GE(compared, 8U);

  const test::ProgramResult made = test::run_well({ILP_GROUND, "map-tiles", "--from", results.string(), "--sun",
                                                   "10,30", "--pixel", "1.6", "--out", again.string()});
  EXPECT_NE(made.output.find("on mars about 137.40"), std::string::npos) << made.output;
  EXPECT_NE(made.output.find("may be off by 0.5"), std::string::npos) << made.output;
}

}  // namespace
}  // namespace ilp
