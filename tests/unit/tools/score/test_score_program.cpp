#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cctype>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>

#include "fsw/records/records.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"
#include "sim/host/metrics.hpp"
#include "sim/host/reference_cameras.hpp"
#include "tests/support/store_records.hpp"
#include "tests/unit/host/scratch_folder.hpp"
#include "tests/unit/tools/score/made_up_strip.hpp"

namespace ilp::score {
namespace {
namespace fs = std::filesystem;
using test::says;
using test::ScratchFolder;
using test::text_of;

constexpr const char* ended_info = R"({"frames": 24, "keyframes": 12, "target_overlap": 0.82})";

std::string name_of(const PoseSample& sample) {
  return "frame-" + std::to_string(sample.keyframe_id) + ".pgm";
}

void write_truth(const StripTrack& track, const fs::path& folder) {
  fs::create_directories(folder);
  std::vector<host::ReferenceCamera> cameras;
  for (const PoseSample& s : track.samples) {
    host::ReferenceCamera camera;
    camera.name = name_of(s);
    camera.camera = {128, 96, 120, 120, 63.5, 47.5};
    camera.cam_from_world = s.true_cam_from_world;
    camera.centre = s.true_centre;
    cameras.push_back(camera);
  }
  host::write_reference_cameras(folder / "poses.txt", "truth", cameras);
}

PoseRecord pose_record(const PoseSample& s, bool final_pose) {
  PoseRecord pose{.id = s.keyframe_id, .strip_id = 1, .state = final_pose ? PoseState::final : PoseState::provisional};
  quaternion_from_rotation(s.cam_from_world, pose.q_cam_from_world);
  for (int k = 0; k < 3; ++k) {
    pose.centre[k] = s.centre[k];
    pose.sigma[k] = 0.001;
  }
  pose.min_depth = 3;
  pose.max_depth = 5;
  return pose;
}

void must(const Status& status) {
  ASSERT_TRUE(status.ok());
}

// Two frames per keyframe. The first `posed` keyframes have final poses.
void write_database(Store& store, const StripTrack& track, std::size_t posed, StripEnd end) {
  Transaction transaction(store);
  must(transaction.begin());
  StripRecord strip;
  strip.id = 1;
  strip.first_keyframe_id = 1;
  strip.last_keyframe_id = static_cast<std::int64_t>(track.samples.size());
  strip.end = end;
  if (!track.samples.empty()) must(put(store, strip));
  for (std::size_t i = 0; i < track.samples.size(); ++i) {
    const PoseSample& s = track.samples[i];
    FrameRecord frame{.id = 2 * s.keyframe_id - 1};
    std::strcpy(frame.name, name_of(s).c_str());
    must(put(store, frame));
    frame.id += 1;
    std::strcpy(frame.name, "between");
    must(put(store, frame));
    KeyframeRecord keyframe;
    keyframe.id = s.keyframe_id;
    keyframe.frame_id = 2 * s.keyframe_id - 1;
    keyframe.strip_id = 1;
    keyframe.index = static_cast<std::int32_t>(i);
    keyframe.overlap = 0.8;
    must(put(store, keyframe));
    must(put(store, pose_record(s, i < posed)));
  }
  must(transaction.commit());
}

struct ProgramRun {
  int status = -1;
  std::string output;
};

ProgramRun run_score(const ScratchFolder& scratch, const std::string& arguments) {
  const fs::path log = scratch / "log";
  const std::string command = std::string(ILP_SCORE_PROGRAM) + " " + arguments + " > " + log.string() + " 2>&1";
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(log)};
}

nlohmann::json score_of(const fs::path& path) {
  return nlohmann::json::parse(text_of(path));
}

// A flight of 12 keyframes that ended by itself, in FOLDER/flight-1.
class ScoreProgram : public testing::Test {
 protected:
  ScoreProgram() {
    fs::create_directories(flight_ / "outbox");
    write_truth(track_, flight_ / "flight" / "truth");
  }
  void fly(std::size_t posed, StripEnd end = StripEnd::end_of_flight) {
    ASSERT_TRUE(store_->open((flight_ / "flight.db").c_str()).ok());
    write_database(*store_, track_, posed, end);
  }
  void land() {
    store_->close();
    scratch_.write("flight-1/flight-info.json", ended_info);
  }
  [[nodiscard]] ProgramRun score(const std::string& more = "") const {
    return run_score(scratch_, flight_.string() + more);
  }
  [[nodiscard]] nlohmann::json result() const { return score_of(flight_ / "score.json"); }

  ScratchFolder scratch_;
  fs::path flight_ = scratch_ / "flight-1";
  StripTrack track_ = test::make_track(12, 20);
  std::unique_ptr<SqliteStore> store_ = std::make_unique<SqliteStore>();
};

TEST_F(ScoreProgram, ExactFlightIsCompleteAndWithoutError) {
  fly(12);
  land();
  const ProgramRun run = score();
  ASSERT_EQ(run.status, 0) << run.output;
  const nlohmann::json json = result();
  EXPECT_EQ(json["version"], 1);
  EXPECT_EQ(json["complete"], true) << run.output;
  EXPECT_EQ(json["frames"], 24);
  EXPECT_EQ(json["posed"], 12);
  EXPECT_EQ(json["strips_count"], 1);
  const nlohmann::json& summary = json["summary"];
  EXPECT_EQ(summary["posed_share"], 1.0);
  EXPECT_EQ(summary["frames_per_keyframe"], 2.0);
  EXPECT_LT(summary["position_max_percent"].get<double>(), 1e-6);
  EXPECT_LT(summary["drift_percent"].get<double>(), 1e-6);
  EXPECT_LT(summary["bow_percent"].get<double>(), 1e-6);
  EXPECT_EQ(summary["sigma1_share"], 1.0);
  EXPECT_TRUE(summary["position_rigid_mean_percent"].is_null()) << "no altimeter";
  EXPECT_EQ(json["keyframes"].size(), 12U);
  EXPECT_TRUE(says(run.output, "position error, mean"));
}

TEST_F(ScoreProgram, EveryLabelIsToldInFullWithItsValueBehindIt) {
  fly(12);
  land();
  const ProgramRun run = score();
  ASSERT_EQ(run.status, 0) << run.output;
  const nlohmann::json summary = result()["summary"];
  std::size_t reported = 0;
  for (const host::Metric& metric : host::metrics()) {
    if (*metric.group == '\0' || !summary.contains(metric.key)) continue;
    const std::size_t at = ("\n" + run.output).find("\n" + std::string(metric.label) + " ");
    ASSERT_NE(at, std::string::npos) << metric.label << "\n" << run.output;
    const std::size_t value = run.output.find_first_not_of(' ', at + std::string_view(metric.label).size());
    EXPECT_TRUE(run.output[value] == '-' || std::isdigit(static_cast<unsigned char>(run.output[value])) != 0)
        << metric.label << "\n"
        << run.output;
    ++reported;
  }
  EXPECT_GT(reported, 20U);
}

TEST_F(ScoreProgram, ErrorsAreInPercentOfTheStripsTrueLength) {
  test::displace(track_.samples[6], Vec3(0, 4, 0));
  fly(12);
  land();
  ASSERT_EQ(score(" --out " + (scratch_ / "elsewhere.json").string()).status, 0);
  const nlohmann::json json = score_of(scratch_ / "elsewhere.json");
  EXPECT_FALSE(fs::exists(flight_ / "score.json"));
  const double length = distance_flown(track_).back();
  EXPECT_NEAR(json["strips"][0]["length"], length, 1e-6);
  EXPECT_NEAR(json["summary"]["position_max_percent"], 100 * 4 / length, 0.3);
  EXPECT_NEAR(json["keyframes"][6]["position_error"], 4, 0.7);
}

TEST_F(ScoreProgram, KilledFlightIsScoredAsFarAsItWentAndLeftAsItIs) {
  fly(8, StripEnd::open);
  scratch_.write("flight-1/outbox/records-000001.ilp", "half a fi");
  // The log is not merged: the database is still open, as after a kill.
  ASSERT_GT(fs::file_size(flight_ / "flight.db-wal"), 0U);
  const std::string database = text_of(flight_ / "flight.db"), log = text_of(flight_ / "flight.db-wal");
  const ProgramRun run = score();
  ASSERT_EQ(run.status, 0) << run.output;
  const nlohmann::json json = result();
  EXPECT_EQ(json["complete"], false);
  EXPECT_EQ(json["posed"], 8);
  EXPECT_LT(json["summary"]["position_max_percent"].get<double>(), 1e-6);
  EXPECT_NEAR(json["summary"]["posed_share"], 8.0 / 12, 1e-12);
  EXPECT_TRUE(says(run.output, "did not end by itself"));
  EXPECT_TRUE(says(run.output, "records-000001.ilp"));
  EXPECT_TRUE(says(run.output, "still open"));
  EXPECT_EQ(text_of(flight_ / "flight.db"), database);
  EXPECT_EQ(text_of(flight_ / "flight.db-wal"), log);
}

TEST_F(ScoreProgram, HalfWrittenFlightInformationIsARemark) {
  fly(12);
  land();
  scratch_.write("flight-1/flight-info.json", R"({"frames": 24, "keyfr)");
  const ProgramRun run = score();
  ASSERT_EQ(run.status, 0) << run.output;
  EXPECT_EQ(result()["complete"], false);
  EXPECT_TRUE(says(run.output, "flight-info.json"));
}

TEST_F(ScoreProgram, FlightWithoutPosesHasNullsAndRemarks) {
  for (const std::size_t posed : {0U, 1U}) {
    fs::remove(flight_ / "flight.db");
    fly(posed);
    land();
    const ProgramRun run = score();
    ASSERT_EQ(run.status, 0) << run.output;
    const nlohmann::json json = result();
    EXPECT_EQ(json["posed"], posed);
    EXPECT_FALSE(json["remarks"].empty());
    for (const char* key : {"position_mean_percent", "rotation_max_deg", "drift_percent", "scale_drift_percent",
                            "bow_percent", "sigma1_share", "position_nes"}) {
      EXPECT_TRUE(json["summary"].at(key).is_null()) << key;
    }
  }
}

TEST_F(ScoreProgram, EmptyFlightIsScored) {
  track_.samples.clear();
  fly(0);
  land();
  ASSERT_EQ(score().status, 0);
  EXPECT_TRUE(result()["summary"]["posed_share"].is_null());
}

TEST_F(ScoreProgram, ReferenceFileStandsInForTruth) {
  fly(12);
  land();
  fs::rename(flight_ / "flight" / "truth" / "poses.txt", scratch_ / "reference.txt");
  const ProgramRun without = score();
  EXPECT_EQ(without.status, 1);
  EXPECT_TRUE(says(without.output, "no truth to score against"));
  const ProgramRun with = score(" --reference " + (scratch_ / "reference.txt").string());
  ASSERT_EQ(with.status, 0) << with.output;
  EXPECT_LT(result()["summary"]["position_max_percent"].get<double>(), 1e-6);
  // Depths of 3 to 5 strip units are stated, a unit is 23.7.
  EXPECT_NEAR(result()["strips"][0]["flying_height"], 4 * 23.7, 1e-6);
}

TEST_F(ScoreProgram, AfterAFlightOverALinkTheStationsFilesCount) {
  fly(12);
  ProductRecord product{.id = 4, .keyframe_id = 1, .kind = ProductKind::image};
  test::write_records(*store_, product);
  land();
  const ProgramRun without = score();
  ASSERT_EQ(without.status, 0) << without.output;
  EXPECT_TRUE(says(without.output, "--received")) << without.output;
  // What the station has received, records too, is read in place of the outbox.
  fs::create_directories(scratch_ / "station");
  scratch_.write("station/product-000001-image.jp2", "no image");
  const ProgramRun with = score(" --received " + (scratch_ / "station").string());
  ASSERT_EQ(with.status, 0) << with.output;
  EXPECT_GT(result()["summary"]["received_mb"].get<double>(), 0);
  EXPECT_FALSE(says(with.output, "name the station's folder"));
  const ProgramRun wrong = score(" --received " + (scratch_ / "nowhere").string());
  EXPECT_EQ(wrong.status, 1);
  EXPECT_TRUE(says(wrong.output, "there is no such folder"));
}

TEST_F(ScoreProgram, BadInputIsNamed) {
  const fs::path empty = scratch_ / "empty";
  fs::create_directories(empty);
  ProgramRun run = run_score(scratch_, empty.string());
  EXPECT_EQ(run.status, 1);
  EXPECT_TRUE(says(run.output, "holds no flight"));

  scratch_.write("flight-1/flight.db", "no database at all, but long enough to be looked at as one");
  run = score();
  EXPECT_EQ(run.status, 1);
  EXPECT_TRUE(says(run.output, "flight.db"));
  fs::remove(flight_ / "flight.db");

  fly(12);
  land();
  scratch_.write("flight-1/flight/truth/poses.txt", "frame-1.pgm 128 96 nonsense\n");
  run = score();
  EXPECT_EQ(run.status, 1);
  EXPECT_TRUE(says(run.output, "line 1"));

  StripTrack other = track_;
  for (PoseSample& s : other.samples) s.keyframe_id += 1000;
  write_truth(other, flight_ / "flight" / "truth");
  run = score();
  EXPECT_EQ(run.status, 1);
  EXPECT_TRUE(says(run.output, "another flight's"));
  EXPECT_FALSE(fs::exists(flight_ / "score.json"));
}

}  // namespace
}  // namespace ilp::score
