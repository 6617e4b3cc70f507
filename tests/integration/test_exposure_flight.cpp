// A simulated flight that sets the exposure of its camera: a dark start, dusk, and a bound of the blur.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "sim/host/reference_cameras.hpp"
#include "tests/integration/flight_files.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {

constexpr double dusk_s = 40, focal_px = 275, blur_px = 0.1;

class ExposureFlight : public ::testing::Test {
 protected:
  static test::ProgramResult fly(const std::string& out, const std::string& mission) {
    std::vector<std::string> command{ILP_SIL, "--scenario", "mars-plains", "--frames", "24",
                                     "--out", out,          "--mission",   mission};
    for (const char* set :
         {"camera.width=320", "camera.height=240", "camera.fx=275", "camera.fy=275", "flight.interval_s=4",
          "effects.gain_step=0", "effects.settable_us=2000", "effects.first_us=20", "effects.light_from_s=40",
          "effects.light_for_s=1000", "effects.light_share=0.02"}) {
      command.insert(command.end(), {"--set", set});
    }
    return test::run_program(command);
  }
  /// What each product has from its start of codestream on (ITU-T T.800, A.4.1).
  static std::map<std::string, test::Bytes> codestreams_of(const std::filesystem::path& out) {
    constexpr std::array<std::uint8_t, 4> start{0xFF, 0x4F, 0xFF, 0x51};
    std::map<std::string, test::Bytes> codestreams;
    for (const auto& [name, bytes] : test::results_of(out)) {
      if (!name.starts_with("product-")) continue;
      codestreams[name].assign(std::search(bytes.begin(), bytes.end(), start.begin(), start.end()), bytes.end());
      EXPECT_FALSE(codestreams[name].empty()) << name;
    }
    EXPECT_FALSE(codestreams.empty());
    return codestreams;
  }
  static std::vector<EventRecord> changes(const std::string& out) {
    std::vector<EventRecord> all = test::records_of<EventRecord>(out);
    std::erase_if(all, [](const EventRecord& event) {
      return event.code != static_cast<std::uint16_t>(StatusCode::exposure_changed);
    });
    return all;
  }
  test::TemporaryFolder folder_;
};

TEST_F(ExposureFlight, FindsTheLightInTheDarkFollowsDuskAndBoundsTheBlur) {
  test::write_file(folder_ / "mission.ini", "[exposure]\nexposure_control = true\nexposure_blur_px = 0.1\n");
  const std::string out = folder_ / "out";
  const test::ProgramResult result = fly(out, folder_ / "mission.ini");
  ASSERT_EQ(result.exit_status, 0) << result.output;
  const auto overlaps = test::records_of<OverlapRecord>(out);
  ASSERT_EQ(overlaps.size(), 24U);
  EXPECT_EQ(overlaps.front().verdict, OverlapVerdict::too_dark) << "a hundredth of the light";
  for (std::size_t i = 4; i < overlaps.size(); ++i) {
    const bool dusk = i >= 10 && i <= 14;  // images between the jump of the light and the answer to it
    EXPECT_TRUE(dusk || overlaps[i].verdict == OverlapVerdict::ok) << i;
  }
  const std::vector<EventRecord> all = changes(out);
  ASSERT_GE(all.size(), 4U);
  // Before dusk: the bright end at 190 of what the light of `settable_us` makes, at the least gain.
  const auto day = std::find_if(all.rbegin(), all.rend(),
                                [](const EventRecord& event) { return 1e-9 * double(event.time_ns) < dusk_s; });
  ASSERT_NE(day, all.rend());
  EXPECT_GT(day->a, 500);
  EXPECT_LT(day->a, 4000);
  EXPECT_EQ(day->b, 1000);
  // After it, fifty times the light is missing: as long an exposure as the speed of the true track allows, and gain.
  const auto cameras = host::read_reference_cameras(folder_ / "out/flight/truth/poses.txt");
  double fastest_px_s = 0, slowest_px_s = 1e9;
  for (std::size_t i = 1; i < cameras.size(); ++i) {
    const double speed = focal_px * (cameras[i].centre - cameras[i - 1].centre).norm() / cameras[i].centre.z() / 4;
    fastest_px_s = std::max(fastest_px_s, speed);
    slowest_px_s = std::min(slowest_px_s, speed);
  }
  const EventRecord& night = all.back();
  EXPECT_GT(1e-9 * static_cast<double>(night.time_ns), dusk_s);
  // The swing of the camera moves the image too: up to three times as fast as the track alone.
  EXPECT_LT(1e-6 * static_cast<double>(night.a), 1.2 * blur_px / slowest_px_s);
  EXPECT_GT(1e-6 * static_cast<double>(night.a), 0.3 * blur_px / fastest_px_s);
  EXPECT_GT(night.b, 1000);
  EXPECT_EQ(test::events_of(out, StatusCode::exposure_not_obeyed), 0U);

  const std::string again = folder_ / "again";
  ASSERT_EQ(fly(again, folder_ / "mission.ini").exit_status, 0);
  test::expect_same_files(test::results_of(out), test::results_of(again));
}

TEST_F(ExposureFlight, ACameraThatCannotBeSetFliesAsItIs) {
  test::write_file(folder_ / "mission.ini", "[exposure]\nexposure_control = true\n");
  const std::string out = folder_ / "out";
  ASSERT_EQ(test::run_program(
                test::sil_command(test::prepared_flights() / "plain", out, {"--mission", folder_ / "mission.ini"}))
                .exit_status,
            0);
  EXPECT_EQ(test::events_of(out, StatusCode::exposure_unsupported), 1U);
  // The products are those of the flight without the parameter, of which only their boxes tell.
  EXPECT_EQ(codestreams_of(out), codestreams_of(test::prepared_flights() / "uninterrupted"));
}

}  // namespace
}  // namespace ilp
