// A flight whose vehicle measures: metres, an upright map and a place on the body, in the simulator and on the ground.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fsw/base/math.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/ground/export/georeference.hpp"
#include "sim/ground/intake/catalogue.hpp"
#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/map/height_error.hpp"
#include "sim/host/reference_cameras.hpp"
#include "tests/integration/flight_files.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

std::vector<std::string> command(const std::string& out, const std::vector<std::string>& more,
                                 const std::string& scenario = "mars-plains", const std::string& frames = "48") {
  std::vector<std::string> words = {ILP_SIL, "--scenario", scenario, "--frames", frames, "--out", out};
  for (const char* setting : {"camera.width=320", "camera.height=240", "camera.fx=275", "camera.fy=275"}) {
    words.insert(words.end(), {"--set", setting});
  }
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

const std::vector<std::string> all_sensors = {"--set", "navigation.altimeter=true", "--set", "navigation.attitude=true",
                                              "--set", "navigation.position=true"};

/// Flown once for all tests here.
const fs::path& flown() {
  static const test::TemporaryFolder folder;
  static const fs::path out = [] {
    const fs::path path = folder / "flight";
    test::run_well(command(path.string(), all_sensors));
    return path;
  }();
  return out;
}

intake::Flight received(const fs::path& out) {
  intake::Outbox outbox = intake::read_outbox(out / "outbox");
  return intake::index_flight(outbox);
}

/// Of the longest way from the first posed keyframe.
double estimated_over_true_length(const intake::Flight& flight, const intake::Strip& strip,
                                  const std::vector<host::ReferenceCamera>& truth) {
  std::map<std::string, Vec3> by_name;
  for (const host::ReferenceCamera& camera : truth) by_name[camera.name] = camera.centre;
  std::optional<std::pair<Vec3, Vec3>> first;
  double reported = 0, real = 0;
  for (const std::int64_t id : strip.keyframes) {
    const intake::Keyframe& keyframe = flight.keyframes.at(id);
    if (!keyframe.posed()) continue;
    const Vec3 centre(keyframe.pose->centre[0], keyframe.pose->centre[1], keyframe.pose->centre[2]);
    const Vec3& at = by_name.at(keyframe.name);
    if (!first) first.emplace(centre, at);
    reported = std::max(reported, (centre - first->first).norm());
    real = std::max(real, (at - first->second).norm());
  }
  return reported / real;
}

TEST(NavigationFlight, TheGroundHasMetresAndALevelMapWithoutAnAnchor) {
  const intake::Flight flight = received(flown());
  ASSERT_EQ(flight.strips.size(), 1U);
  const intake::Strip& strip = flight.strips.begin()->second;
  ASSERT_TRUE(strip.frame);
  EXPECT_STREQ(intake::unit_of(flight, strip), "m");
  EXPECT_GT(strip.frame->scale_sigma, 0);
  EXPECT_LT(strip.frame->scale_sigma, 0.005);

  const auto truth = host::read_reference_cameras(flown() / "flight" / "truth" / "poses.txt");
  std::map<std::string, const host::ReferenceCamera*> by_name;
  for (const auto& camera : truth) by_name[camera.name] = &camera;
  double tilt = 0;
  std::size_t posed = 0;
  for (const std::int64_t id : strip.keyframes) {
    const intake::Keyframe& keyframe = flight.keyframes.at(id);
    if (!keyframe.posed()) continue;
    const host::ReferenceCamera& camera = *by_name.at(keyframe.name);
    ++posed;
    const Mat3 turn = rotation_from_quaternion(keyframe.pose->q_cam_from_world).transpose() * camera.cam_from_world;
    tilt += det_acos(turn(2, 2));
  }
  ASSERT_GT(posed, 8U);
  EXPECT_NEAR(estimated_over_true_length(flight, strip, truth), 1, 0.005) << "bar of the scale";
  EXPECT_LT(tilt / static_cast<double>(posed), 0.0035) << "0.2 degrees over these few keyframes";

  const exports::Georeference place = exports::georeference_of(flight, strip, nullptr);
  EXPECT_TRUE(place.on_a_body());
  EXPECT_EQ(place.unit, "metre");
  EXPECT_NE(place.sentence.find("Mars"), std::string::npos) << place.sentence;
  EXPECT_NE(place.sentence.find("navigation"), std::string::npos) << place.sentence;
}

/// By the first height alone, the metre of these flights is off by 0.4 to 1.7 %.
TEST(NavigationFlight, AllHeightsOfTheImagesSetTheMetreWithAStatedError) {
  const test::TemporaryFolder folder;
  double squares = 0;
  int flights = 0;
  for (const char* scenario : {"mars-plains", "mars-canyon"}) {
    for (const char* seed : {"1", "2", "3"}) {
      const fs::path out = folder / (std::string(scenario) + seed);
      test::run_well(command(out.string(), {"--seed", seed, "--set", "flight.altimeter=true"}, scenario, "24"));
      const intake::Flight flight = received(out);
      const intake::Strip& strip = flight.strips.begin()->second;
      ASSERT_TRUE(strip.frame) << scenario << " " << seed;
      EXPECT_STREQ(intake::unit_of(flight, strip), "m");
      const auto truth = host::read_reference_cameras(out / "flight" / "truth" / "poses.txt");
      const double error = estimated_over_true_length(flight, strip, truth) - 1;
      EXPECT_LT(std::fabs(error), 2 * strip.frame->scale_sigma) << scenario << " " << seed;
      EXPECT_LT(strip.frame->scale_sigma, 0.012) << scenario << " " << seed;
      squares += error * error / (strip.frame->scale_sigma * strip.frame->scale_sigma);
      ++flights;
      const map::HeightErrors errors = map::height_errors_of(flight, strip);
      EXPECT_EQ(errors.scale_sigma, strip.frame->scale_sigma) << "a height's error contains that of the metre";
    }
  }
  EXPECT_LT(squares / flights, 1);
}

TEST(NavigationFlight, KillsChangeNothing) {
  const test::TemporaryFolder folder;
  const fs::path images = flown() / "flight";
  const auto words = [&](const std::string& out, const std::vector<std::string>& more) {
    std::vector<std::string> all = test::sil_command(images, out, more);
    all.insert(all.end(), {"--navigation", (images / "navigation.csv").string()});
    return all;
  };
  const fs::path whole = folder / "whole", killed = folder / "killed";
  ASSERT_EQ(test::run_program(words(whole.string(), {})).exit_status, 0);
  ASSERT_EQ(test::run_program(words(killed.string(), {"--power-cut-after", "300"})).exit_status, 9);
  ASSERT_EQ(test::run_program(words(killed.string(), {"--resume", "--power-cut-after", "250"})).exit_status, 9);
  ASSERT_EQ(test::run_program(words(killed.string(), {"--resume"})).exit_status, 0);
  test::expect_same_files(test::files_of(whole / "outbox", {"product-", "records-", "points-"}),
                          test::files_of(killed / "outbox", {"product-", "records-", "points-"}));
  const auto a = test::records_of<StripFrameRecord>(whole), b = test::records_of<StripFrameRecord>(killed);
  ASSERT_EQ(a.size(), 1U);
  ASSERT_EQ(b.size(), 1U);
  EXPECT_EQ(a[0].metres_per_unit, b[0].metres_per_unit);
  EXPECT_EQ(a[0].through_keyframe_id, b[0].through_keyframe_id);
}

TEST(NavigationFlight, WithoutMeasurementsTheFlightIsWhatItWas) {
  const test::TemporaryFolder folder;
  const test::ProgramResult plain = test::run_well(test::sil_command(flown() / "flight", folder / "plain", {}));
  EXPECT_TRUE(test::records_of<NavigationRecord>(folder / "plain").empty());
  EXPECT_TRUE(test::records_of<StripFrameRecord>(folder / "plain").empty());
  const intake::Flight flight = received(folder / "plain");
  EXPECT_STREQ(intake::unit_of(flight, flight.strips.begin()->second), "units");
}

TEST(NavigationFlight, AFileThatIsNoneIsRefusedByName) {
  const test::TemporaryFolder folder;
  test::write_file(folder / "bad.csv", "time_s,height_ft\n1,2\n");
  const test::ProgramResult refused =
      test::run_program(test::sil_command(flown() / "flight", folder / "out", {"--navigation", folder / "bad.csv"}));
  EXPECT_EQ(refused.exit_status, 1);
  EXPECT_NE(refused.output.find("bad.csv"), std::string::npos) << refused.output;
}

}  // namespace
}  // namespace ilp
