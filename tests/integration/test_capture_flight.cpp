// Flights whose images are taken when the flight software says: a triggered camera over a simulated world.
#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogr_spatialref.h>

#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "cfg/mission.hpp"
#include "sim/host/gdal_session.hpp"
#include "sim/host/geo_raster.hpp"
#include "tests/integration/flight_files.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

class CaptureFlightTest : public testing::Test {
 protected:
  /// A quarter of the pixels: an image is rendered in a quarter of the time.
  test::ProgramResult fly(const fs::path& to, const std::string& mission, const std::vector<std::string>& more) {
    test::write_file(folder / "mission.ini", mission);
    std::vector<std::string> arguments{ILP_SIL, "--mission", folder / "mission.ini", "--out", to.string()};
    for (const char* setting : {"camera.width=320", "camera.height=240", "camera.fx=275", "camera.fy=275"}) {
      arguments.insert(arguments.end(), {"--set", setting});
    }
    arguments.insert(arguments.end(), more.begin(), more.end());
    return test::run_program(arguments);
  }
  /// The share of a's footprint that b sees, from the simulator's truth; by numbers of frames.
  static std::map<std::pair<std::int64_t, std::int64_t>, double> true_overlaps(const fs::path& flight) {
    std::map<std::pair<std::int64_t, std::int64_t>, double> overlaps;
    std::ifstream in(flight / "flight" / "truth" / "overlap.csv");
    std::string line;
    std::getline(in, line);
    while (std::getline(in, line)) {
      std::istringstream words(line);
      std::string a, b, seen, footprint;
      std::getline(words, a, ',');
      std::getline(words, b, ',');
      std::getline(words, seen, ',');
      std::getline(words, footprint, ',');
      overlaps[{std::stoll(a), std::stoll(b)}] = std::stod(footprint);
    }
    return overlaps;
  }

  test::TemporaryFolder folder;
  fs::path out = folder / "out";
};

constexpr const char* forecast_mode = "[acquisition]\ncapture_mode = 1\n";
constexpr const char* telecommand_mode = "[acquisition]\ncapture_mode = 2\ncapture_min_interval_s = 0.1\n";

TEST_F(CaptureFlightTest, ABurstShowsHowARollingShutterMovedWhereImagesAreRare) {
  std::vector<std::string> swing{"--frames", "24"};
  for (const char* setting : {"flight.drift_m_s=3", "flight.swing_rad=0.08", "flight.suspension_m=4",
                              "flight.gravity_m_s2=9.81", "effects.readout_s=0.03", "camera.readout_s=0.03"}) {
    swing.insert(swing.end(), {"--set", setting});
  }
  // The share of the keyframes about which four frames tell the motion.
  const auto known = [](const fs::path& flight) {
    std::size_t all_frames = 0;
    const auto shutters = test::records_of<ShutterRecord>(flight);
    for (const ShutterRecord& shutter : shutters) {
      if (shutter.source == MotionSource::frames && shutter.frames == 4) ++all_frames;
    }
    EXPECT_GT(shutters.size(), 5U);
    return static_cast<double>(all_frames) / static_cast<double>(shutters.size());
  };
  const test::ProgramResult with = fly(out, forecast_mode, swing);
  ASSERT_EQ(with.exit_status, 0) << with.output;
  EXPECT_GT(known(out), 0.6) << "all but the first and those that a forecast moved";
  std::map<std::int64_t, CaptureSource> source;
  for (const auto& capture : test::records_of<CaptureRecord>(out)) source[capture.frame_id] = capture.source;
  for (const auto& keyframe : test::records_of<KeyframeRecord>(out)) {
    EXPECT_NE(source.at(keyframe.frame_id), CaptureSource::burst) << keyframe.id;
  }
  const fs::path bare = folder / "bare";
  const test::ProgramResult without = fly(bare, std::string(forecast_mode) + "capture_burst = false\n", swing);
  ASSERT_EQ(without.exit_status, 0) << without.output;
  EXPECT_LT(known(bare), 0.2);
}

TEST_F(CaptureFlightTest, InGustsTheForecastKeepsTheTargetOverlapWithAlmostEveryImage) {
  const test::ProgramResult result = fly(out, forecast_mode, {"--frames", "120"});
  ASSERT_EQ(result.exit_status, 0) << result.output;
  const auto truth = true_overlaps(out);
  const auto keyframes = test::records_of<KeyframeRecord>(out);
  ASSERT_GT(keyframes.size(), 20U);
  EXPECT_EQ(test::records_of<StripRecord>(out).size(), 1U);
  double sum = 0, squares = 0, n = 0;
  // The first keyframes teach the motion.
  for (std::size_t k = 4; k < keyframes.size(); ++k) {
    const auto found = truth.find({keyframes[k - 1].frame_id, keyframes[k].frame_id});
    ASSERT_NE(found, truth.end());
    const double error = found->second - MissionParameters{}.target_overlap;
    sum += error;
    squares += error * error;
    n += 1;
  }
  EXPECT_LT(std::sqrt(squares / n - sum * sum / (n * n)), 0.02);
  EXPECT_LT(std::fabs(sum / n), 0.015);
  const double frames = static_cast<double>(test::records_of<FrameRecord>(out).size());
  EXPECT_LT(frames / static_cast<double>(keyframes.size()), 1.3);
  for (const auto& capture : test::records_of<CaptureRecord>(out)) {
    if (capture.state != CaptureState::exposed) continue;
    EXPECT_LE(std::llabs(capture.exposed_ns - capture.requested_ns), 500'000);
  }
}

TEST_F(CaptureFlightTest, APowerCutChangesNoCaptureAndNoProduct) {
  ASSERT_EQ(fly(out, forecast_mode, {"--frames", "30"}).exit_status, 0);
  const fs::path cut = folder / "cut";
  const test::ProgramResult result =
      fly(cut, forecast_mode, {"--frames", "30", "--set", "faults.power_cut_after_s=31"});
  ASSERT_EQ(result.exit_status, 0) << result.output;
  test::expect_same_files(test::results_of(out), test::results_of(cut));
}

TEST_F(CaptureFlightTest, TelecommandedImagesAreExposedAtTheirTimesAndEveryCommandIsOnRecord) {
  std::string commands = "# twenty images, a tenth of a second apart\n";
  for (int k = 0; k < 20; ++k) commands += "2 capture " + std::to_string(20 + 0.1 * k) + "\n";
  commands += "30 capture 29.5   # in the past\n30 capture 35.0004\n30 capture 35.05 # too near\n";
  test::write_file(folder / "commands.txt", commands);
  const test::ProgramResult result =
      fly(out, telecommand_mode, {"--frames", "30", "--telecommands", folder / "commands.txt"});
  ASSERT_EQ(result.exit_status, 0) << result.output;
  const auto captures = test::records_of<CaptureRecord>(out);
  const auto frames = test::records_of<FrameRecord>(out);
  ASSERT_EQ(captures.size(), 23U);
  ASSERT_EQ(frames.size(), 21U);
  std::size_t exposed = 0, rejected = 0;
  for (const CaptureRecord& capture : captures) {
    EXPECT_EQ(capture.source, CaptureSource::telecommand);
    rejected += capture.state == CaptureState::rejected ? 1U : 0U;
    if (capture.state != CaptureState::exposed) continue;
    ++exposed;
    // The camera's own granularity is a millisecond.
    EXPECT_LE(std::llabs(capture.exposed_ns - capture.requested_ns), 500'000);
    EXPECT_EQ(frames.at(static_cast<std::size_t>(capture.frame_id) - 1).time_ns, capture.exposed_ns);
  }
  EXPECT_EQ(exposed, 21U);
  EXPECT_EQ(rejected, 2U);
  EXPECT_EQ(test::events_of(out, StatusCode::capture_in_past), 1U);
  EXPECT_EQ(test::events_of(out, StatusCode::capture_too_soon), 1U);
}

TEST_F(CaptureFlightTest, AMalformedTelecommandIsNamed) {
  test::write_file(folder / "commands.txt", "2 capture 20\n3 fire 21\n");
  const test::ProgramResult result =
      fly(out, telecommand_mode, {"--frames", "5", "--telecommands", folder / "commands.txt"});
  EXPECT_EQ(result.exit_status, 1);
  EXPECT_NE(result.output.find("commands.txt, line 2"), std::string::npos) << result.output;
}

// GDAL looks the system of coordinates of a terrain file up with SQLite, in the process that flies.
TEST_F(CaptureFlightTest, TerrainInAKnownProjectionTakesNoneOfTheFlightsSqliteMemory) {
  const fs::path terrain = folder / "terrain.tif";
  const auto peak_bytes = [&](const fs::path& to) {
    const test::ProgramResult result =
        fly(to, "",
            {"--frames", "3", "--set", "world.map_georeferenced=true", "--set", "world.heightmap=" + terrain.string()});
    EXPECT_EQ(result.exit_status, 0) << result.output;
    std::ifstream in(to / "flight-info.json");
    return nlohmann::json::parse(in).at("sqlite_arena_peak_bytes").get<std::size_t>();
  };
  host::Raster<float> heights(200, 200);
  for (int k = 0; k < 200; ++k) heights.at(k, k) = 1;
  host::write_geotiff(terrain, heights.view(), {-400, 400, 4, 4});
  const std::size_t local = peak_bytes(out);
  {
    OGRSpatialReference utm;
    ASSERT_EQ(utm.importFromEPSG(32633), OGRERR_NONE);
    const host::Dataset file(GDALDataset::Open(terrain.c_str(), GDAL_OF_RASTER | GDAL_OF_UPDATE));
    ASSERT_EQ(file->SetSpatialRef(&utm), CE_None);
  }
  const std::size_t projected = peak_bytes(folder / "projected");
  EXPECT_LE(projected, limits::sqlite_arena_bytes);
  EXPECT_NEAR(static_cast<double>(projected), static_cast<double>(local), 65536);
  test::expect_same_files(test::results_of(out), test::results_of(folder / "projected"));
}

}  // namespace
}  // namespace ilp
