// What is read first: errors of the model that is delivered, the parts of a height's error, and why nothing is mapped.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "sim/ground/map/ground_grid.hpp"
#include "sim/ground/report/accuracy_summary.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::report {
namespace {

std::string joined_text(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

bool says(const std::vector<std::string>& lines, const char* what) {
  return joined_text(lines).find(what) != std::string::npos;
}

/// Eighteen poses over 200 m, 0.05 m off, of strips 1 and 2 in one model; the flight's own poses are scored four times
/// as bad.
Report joined_report() {
  Report report;
  report.has_reference = true;
  StripResult& strip = report.strips.emplace_back();
  strip.strip.id = 1;
  strip.strip.record.emplace().end = StripEnd::overlap_lost;
  StripAccuracy accuracy{.poses = 18, .length = 200};
  accuracy.position.mean = 0.05;
  accuracy.position.max = 0.1;
  strip.accuracy = accuracy;
  model::JoinedModel model{.strip_id = 1, .strips = {1, 2}};
  report.joined.models.push_back(model);
  ScoreFile score;
  score.complete = true;
  score.summary = {{"position_mean_percent", 0.1}, {"position_max_percent", 0.2}, {"rotation_mean_deg", 0.3}};
  report.score = score;
  return report;
}

TEST(AccuracySummary, AReferenceOfAnotherFlightIsNamed) {
  Report report = joined_report();
  report.strips[0].accuracy->rotation_rad.mean = 0.4;
  EXPECT_TRUE(
      says(accuracy_lines(report), "strip 1: after the best alignment, 18 poses and the reference differ by 22.9"));
  report.strips[0].accuracy->rotation_rad.mean = 0.01;
  report.strips[0].accuracy->position.mean = 30;
  EXPECT_TRUE(says(accuracy_lines(report), "is the reference of this flight?"));
  report.strips[0].accuracy->length = 0;
  EXPECT_FALSE(says(accuracy_lines(report), "is the reference of this flight?")) << "hovers: no share is known";
  report.strips[0].accuracy->length = 200;
  report.strips[0].accuracy->poses = 3;
  EXPECT_FALSE(says(accuracy_lines(report), "is the reference of this flight?")) << "too few to tell";
}

TEST(AccuracySummary, TheDeliveredModelComesFirstAndTheStripsOnBoardSecond) {
  Report report = joined_report();
  ASSERT_TRUE(model_is_measured(report));
  const std::string text = joined_text(accuracy_lines(report));
  const std::size_t model = text.find("position error of the joined model: mean 0.025 %, largest 0.050 %"),
                    poses = text.find("18 poses"), board = text.find("position error: mean 0.100 %");
  ASSERT_NE(model, std::string::npos) << text;
  EXPECT_NE(poses, std::string::npos) << text;
  ASSERT_NE(board, std::string::npos) << text;
  EXPECT_LT(model, board);
  EXPECT_EQ(text.find("is the reference of this flight?"), std::string::npos);
  // Without a model nothing changes: the score stands alone.
  report.joined.models.clear();
  EXPECT_FALSE(model_is_measured(report));
  EXPECT_EQ(joined_text(accuracy_lines(report)).find("joined"), std::string::npos);
}

TEST(AccuracySummary, AJoinedStripDoesNotEndByLostOverlap) {
  Report report = joined_report();
  EXPECT_EQ(strip_end(report, report.strips[0].strip), "joined from strips 1, 2");
  report.joined.models[0].strips = {1};
  EXPECT_EQ(strip_end(report, report.strips[0].strip), words_of(StripEnd::overlap_lost));
}

TEST(AccuracySummary, NothingIsToldWithItsCauseAndWhatToDo) {
  Report report;
  EXPECT_TRUE(says(nothing_lines(report), "no keyframe"));
  for (std::int64_t id = 1; id <= 3; ++id) {
    intake::Keyframe& keyframe = report.flight.keyframes[id];
    keyframe.id = id;
    keyframe.pose.emplace();
    keyframe.pose->state = PoseState::failed;
    keyframe.pose->verdict = id == 1 ? PoseVerdict::waiting : PoseVerdict::too_few_matches;
  }
  const std::vector<std::string> lines = nothing_lines(report);
  EXPECT_TRUE(says(lines, "none of the 3 keyframes has a pose")) << joined_text(lines);
  EXPECT_TRUE(says(lines, "of 2 of them: too few matches")) << joined_text(lines);
  EXPECT_TRUE(says(lines, "What to do")) << joined_text(lines);
  report.flight.keyframes[2].pose->state = PoseState::final;
  EXPECT_TRUE(nothing_lines(report).empty());
}

TEST(AccuracySummary, MeasurementsThatContradictAndMissingMetresAreTold) {
  Report report;
  StripResult& strip = report.strips.emplace_back();
  strip.strip.id = 4;
  strip.grid.emplace(0, 0, 1, 2, 2);
  StripFrameRecord frame{.verdict = StripFrameVerdict::attitudes_contradict};
  strip.strip.frame = frame;
  const std::vector<std::string> lines = estimated_error_lines(report);
  EXPECT_TRUE(says(lines, "strip 4: the vehicle's measurements contradict each other: what is up by the attitudes"))
      << joined_text(lines);
  EXPECT_TRUE(says(lines, "not in metres")) << joined_text(lines);
  strip.strip.frame->verdict = StripFrameVerdict::nothing_measured;
  EXPECT_FALSE(says(estimated_error_lines(report), "contradict"));
}

TEST(AccuracySummary, AFourthOfTheMeasurementsOfAKindThatIsRefusedIsTold) {
  Report report;
  StripFrameRecord frame{.heights_used = 10, .heights_refused = 2, .positions_used = 6, .positions_refused = 4};
  report.strips.emplace_back().strip.id = 1;
  report.strips[0].strip.frame = frame;
  EXPECT_TRUE(says(estimated_error_lines(report), "strip 1: 4 of 10 positions contradict the others and are left out"));
  EXPECT_FALSE(says(estimated_error_lines(report), "heights"));
}

/// Events that a reader must see. A calibration that leaves something open is one of them.
TEST(AccuracySummary, VerdictsOnTheCameraAreEventsOfMediumSeverity) {
  for (const StatusCode code :
       {StatusCode::camera_nominal, StatusCode::camera_contradicted, StatusCode::camera_unexplained,
        StatusCode::navigation_contradicts, StatusCode::navigation_unused})
    EXPECT_GE(status_severity(code), Severity::medium) << static_cast<int>(code);
}

TEST(HeightErrors, ConsistOfTheirPartsEachByItsOwnLever) {
  intake::Flight flight;
  intake::Strip strip;
  strip.id = 1;
  for (std::int64_t id = 1; id <= 2; ++id) {
    intake::Keyframe& keyframe = flight.keyframes[id];
    keyframe.pose.emplace();
    keyframe.pose->state = PoseState::final;
    keyframe.pose->centre[0] = id == 1 ? -10 : 30;
    keyframe.pose->centre[2] = 100;
    keyframe.pose->sigma[2] = 0.3;
    keyframe.depth.emplace();
    keyframe.depth->pose_sigma = id == 1 ? 0.004 : 0;
    strip.keyframes.push_back(id);
  }
  StripFrameRecord frame{.scale_sigma = 0.002, .tilt_sigma_rad = 0.01, .vertical_sigma_m = 1.2};
  strip.frame = frame;
  const map::HeightErrors errors = map::height_errors_of(flight, strip);
  // 100 m below the first camera, 50 m beside the middle of the track, which is at x = 10.
  const map::HeightErrorParts parts = errors.parts(Vec3(10, 50, 0), 1, 0.5);
  EXPECT_DOUBLE_EQ(parts.matching, 0.5);
  EXPECT_DOUBLE_EQ(parts.poses, std::sqrt(0.4 * 0.4 + 0.3 * 0.3));
  EXPECT_DOUBLE_EQ(parts.scale, 0.2);
  EXPECT_DOUBLE_EQ(parts.tilt, 0.5);
  EXPECT_DOUBLE_EQ(parts.place, 1.2);
  EXPECT_DOUBLE_EQ(parts.whole(), std::sqrt(0.25 + 0.25 + 0.04 + 0.25 + 1.44));
  EXPECT_DOUBLE_EQ(errors.parts(Vec3(10, 50, 0), 2, 0.5).poses, 0.3);
  EXPECT_DOUBLE_EQ(errors.parts(Vec3(10, 50, 0), 0, std::nan("")).whole(), std::sqrt(0.04 + 0.25 + 1.44));
  // A strip whose unit nobody knows has no place in metres, and hostile records state nothing.
  strip.frame->scale_sigma = 0;
  EXPECT_EQ(map::height_errors_of(flight, strip).place_sigma, 0);
  flight.keyframes[1].pose->sigma[2] = std::nan("");
  flight.keyframes[1].depth->pose_sigma = -1;
  EXPECT_EQ(map::height_errors_of(flight, strip).parts(Vec3(10, 10, 0), 1, 0.5).poses, 0);
  EXPECT_NE(errors.digest(), map::height_errors_of(flight, strip).digest());
}

TEST(HeightErrors, OfAStripThatControlPointsHavePlacedHaveTheErrorsOfThese) {
  intake::Flight flight;
  intake::Strip strip;
  intake::Keyframe& keyframe = flight.keyframes[1];
  keyframe.pose.emplace();
  keyframe.pose->state = PoseState::final;
  keyframe.pose->centre[2] = 100;
  strip.keyframes.push_back(1);
  strip.frame.emplace();
  strip.frame->scale_sigma = 0.5;
  strip.frame->tilt_sigma_rad = 0.5;
  strip.control.emplace();
  strip.control->scale_sigma = 0.002;
  strip.control->tilt_sigma_rad = 0.01;
  strip.control->height_sigma_m = 0.7;
  const map::HeightErrorParts parts = map::height_errors_of(flight, strip).parts(Vec3(0, 50, 0), 1, 0.1);
  EXPECT_DOUBLE_EQ(parts.scale, 0.2);
  EXPECT_DOUBLE_EQ(parts.tilt, 0.5);
  EXPECT_DOUBLE_EQ(parts.place, 0.7);
}

TEST(HeightErrors, OfAUnitByTheFirstHeightAloneContainTheScale) {
  intake::Flight flight;
  intake::Strip strip;
  for (std::int64_t id = 1; id <= 2; ++id) {
    intake::Keyframe& keyframe = flight.keyframes[id];
    keyframe.pose.emplace();
    keyframe.pose->state = PoseState::final;
    keyframe.pose->centre[2] = 100;
    strip.keyframes.push_back(id);
  }
  EXPECT_EQ(map::height_errors_of(flight, strip).scale_sigma, 0) << "a strip without a metre";
  for (auto& [id, keyframe] : flight.keyframes) keyframe.pose->scale_source = ScaleSource::altimeter;
  EXPECT_DOUBLE_EQ(map::height_errors_of(flight, strip).parts(Vec3(0, 50, 0), 1, 0.1).scale, 2);
}

TEST(HeightErrors, OfAGridAreThoseOfItsCells) {
  map::GroundGrid grid(0, 0, 2, 4, 1);
  grid.height.samples = {1, std::nanf(""), 5, 5};
  grid.sigma.samples = {0.3F, 0.3F, 0.4F, 0.35F};
  grid.source.samples = {1, 1, 1, 0};
  map::HeightErrors errors{.keyframes = {{11, 0, 0.04}}, .tilt_sigma_rad = 0.1};
  const host::Raster<float> whole = map::whole_sigma_of(grid, errors);
  EXPECT_NEAR(whole.samples[0], std::hypot(0.3, 0.4), 1e-6);
  EXPECT_TRUE(std::isnan(whole.samples[1]));
  EXPECT_NEAR(whole.samples[2], std::hypot(0.4, 0.24, 0.4), 1e-6) << "four units beside the middle of the track";
  EXPECT_NEAR(map::usual_parts(grid, errors).matching, 0.35, 1e-6);
}

}  // namespace
}  // namespace ilp::report
