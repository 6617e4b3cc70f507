#include <algorithm>
#include <cmath>
#include <memory>
#include <set>

#include "fsw/imaging/overlap_checker.hpp"
#include "tests/support/failing_store.hpp"
#include "tests/support/step_memory.hpp"
#include "tests/support/strip.hpp"
#include "tests/unit/shared/component_fixture.hpp"

namespace ilp {
namespace {

constexpr std::int32_t width = 320;
constexpr std::int32_t height = 240;
/// So far away that no pixel is seen twice.
constexpr double elsewhere_px = 20'000;

/// Frames are windows on one landscape, so the true overlap of two of them is 1 - distance / width.
class OverlapCheckerTest : public test::ComponentTest {
 protected:
  OverlapCheckerTest() { EXPECT_TRUE(checker->restore().ok()); }

  void add(const test::Image& image) {
    ++frames;
    write_frame(frames, image, frames * ns_per_s);
  }
  static test::Image view_at(double x) {
    return test::render_texture(width, height, Similarity2{1, 0, 1000 + x, 2000}, 1, 0, 0, 1);
  }
  void add_at(double x) { add(view_at(x)); }
  /// The landscape from a camera that has gone about the middle of the image: the distances of the right border and of
  /// the left one differ by (1 + turn / 2) / (1 - turn / 2).
  static test::Image view_turned_by(double turn) {
    test::Image image(width, height);
    for (std::int32_t y = 0; y < height; ++y) {
      for (std::int32_t x = 0; x < width; ++x) {
        const double dx = x - 0.5 * (width - 1), dy = y - 0.5 * (height - 1);
        const double distance = 1 + turn * dx / width;
        const double value = test::fractal_texture(1200 + dx / distance, 2100 + dy / distance, 5, 1);
        image.pixels[static_cast<std::size_t>(y * width + x)] =
            static_cast<std::uint8_t>(std::clamp(std::floor(value + 0.5), 0.0, 255.0));
      }
    }
    return image;
  }
  void command(StripEnd reason) {
    CommandRecord record{.id = number_of<CommandRecord>() + 1, .reason = reason, .after_frame_id = frames};
    write(record);
  }
  OverlapDecision decision(std::int64_t frame) { return read<OverlapRecord>(frame).decision; }
  OverlapVerdict verdict(std::int64_t frame) { return read<OverlapRecord>(frame).verdict; }
  /// Frames of the keyframes of a strip.
  std::vector<std::int64_t> keyframes(std::int64_t strip) {
    std::vector<std::int64_t> chosen;
    for (const KeyframeRecord& keyframe : test::records_of<KeyframeRecord>(store)) {
      if (keyframe.strip_id != strip) continue;
      EXPECT_EQ(keyframe.index, static_cast<std::int32_t>(chosen.size()));
      chosen.push_back(keyframe.frame_id);
    }
    return chosen;
  }
  using Frames = std::vector<std::int64_t>;

  std::int64_t frames = 0;
  std::unique_ptr<OverlapChecker> checker =
      std::make_unique<OverlapChecker>(store, mission, test::step_memory<OverlapChecker>());
};

TEST_F(OverlapCheckerTest, TheFirstFrameAtTheTargetBecomesTheNextKeyframe) {
  for (const double x : {0, 20, 40, 60, 80, 100, 121}) add_at(x);
  EXPECT_TRUE(run(*checker).empty());
  EXPECT_EQ(keyframes(1), (Frames{1, 4, 7}));
  EXPECT_EQ(decision(1), OverlapDecision::new_strip);
  EXPECT_EQ(decision(2), OverlapDecision::skipped);
  EXPECT_EQ(decision(4), OverlapDecision::selected);
  EXPECT_EQ(decision(6), OverlapDecision::skipped);
  EXPECT_NEAR(read<OverlapRecord>(3).overlap, 1 - 40.0 / width, 0.01);

  const auto second = read<KeyframeRecord>(2);
  EXPECT_NEAR(second.overlap, 1 - 60.0 / width, 0.01);
  EXPECT_EQ(second.time_ns, 4 * ns_per_s);
  // The previous keyframe's pixel (x, y) is seen 60 px further left.
  EXPECT_NEAR(second.plane_from_previous[0], 1, 0.01);
  EXPECT_NEAR(second.plane_from_previous[2], -60, 1.5);
  EXPECT_NEAR(second.plane_from_previous[5], 0, 1.5);

  const auto strip = read<StripRecord>(1);
  EXPECT_EQ(strip.first_keyframe_id, 1);
  EXPECT_EQ(strip.last_keyframe_id, 3);
  EXPECT_EQ(strip.end, StripEnd::open);
}

TEST_F(OverlapCheckerTest, AKeyframeTellsTheLevelOfWorkThatItWasChosenUnder) {
  add_at(0);
  run(*checker);
  TimingRecord timing{.degraded = 2};
  write(timing);
  add_at(60);
  run(*checker);
  timing.degraded = 1;
  write(timing);
  add_at(120);
  run(*checker);
  EXPECT_EQ(read<KeyframeRecord>(1).degraded, 0);
  EXPECT_EQ(read<KeyframeRecord>(2).degraded, 2);
  EXPECT_EQ(read<KeyframeRecord>(3).degraded, 1);
}

TEST_F(OverlapCheckerTest, AFrameOfABurstShowsTheMotionAndDecidesNothing) {
  CameraRecord lens{.readout_s = 0.03};
  write(lens);
  CaptureRecord beside{.id = 7, .source = CaptureSource::burst};
  write(beside);
  const auto add_beside = [&](double x) {
    add_at(x);
    auto frame = read<FrameRecord>(frames);
    frame.capture_id = beside.id;
    const test::Image image = view_at(x);
    write(frame, "image", image.pixels);
  };
  add_beside(0);
  for (const double x : {0, 20}) add_at(x);
  add_beside(70);  // below the target
  add_beside(elsewhere_px);
  add_at(60);
  add_beside(65);
  EXPECT_TRUE(run(*checker).empty());
  EXPECT_EQ(keyframes(1), (Frames{2, 6}));
  for (const std::int64_t id : {1, 4, 5, 7}) EXPECT_EQ(decision(id), OverlapDecision::burst) << id;
  EXPECT_EQ(verdict(4), OverlapVerdict::ok);
  EXPECT_EQ(verdict(5), OverlapVerdict::overlap_unknown);
  EXPECT_NEAR(read<FramePlaneRecord>(4).plane_from_keyframe[2], -70, 1.5);
  EXPECT_EQ(read<FramePlaneRecord>(7).keyframe_id, 2);
  EXPECT_NEAR(read<FramePlaneRecord>(7).plane_from_keyframe[2], -5, 0.5);
}

TEST_F(OverlapCheckerTest, AKeyframeSaysHowFarTheGroundMovedDuringItsExposure) {
  for (const double x : {0, 60, 120}) add_at(x);
  auto frame = read<FrameRecord>(2);
  frame.exposure_us = 50'000;
  const test::Image image = view_at(60);
  write(frame, "image", image.pixels);
  run(*checker);
  EXPECT_TRUE(std::isnan(read<KeyframeRecord>(1).blur_px)) << "the first of a strip";
  EXPECT_NEAR(read<KeyframeRecord>(2).blur_px, 60 * 0.05, 0.1) << "60 px in a second";
  EXPECT_TRUE(std::isnan(read<KeyframeRecord>(3).blur_px)) << "exposure not known";
}

TEST_F(OverlapCheckerTest, TheTargetOfTheMissionCounts) {
  mission.target_overlap = 0.9;
  for (const double x : {0, 20, 40, 60}) add_at(x);
  run(*checker);
  EXPECT_EQ(keyframes(1), (Frames{1, 3}));
}

TEST_F(OverlapCheckerTest, WhenTheNextFrameIsTooFarTheOneBeforeBridgesTheGap) {
  for (const double x : {0, 40, 180}) add_at(x);  // 87 %, then 44 % of the keyframe, but 56 % of the frame before
  EXPECT_TRUE(run(*checker).empty());
  EXPECT_EQ(keyframes(1), (Frames{1, 2, 3}));
  EXPECT_NEAR(read<KeyframeRecord>(2).overlap, 1 - 40.0 / width, 0.01);
  EXPECT_NEAR(read<KeyframeRecord>(2).plane_from_previous[2], -40, 1.5);
  EXPECT_NEAR(read<KeyframeRecord>(3).overlap, 1 - 140.0 / width, 0.02);
  EXPECT_EQ(read<OverlapRecord>(3).keyframe_id, 2);
}

TEST_F(OverlapCheckerTest, TheCandidateIsTheFrameWithTheLeastOverlapSoFar) {
  for (const double x : {0, 45, 20, 180}) add_at(x);  // the balloon swings back before the gap
  run(*checker);
  EXPECT_EQ(keyframes(1), (Frames{1, 2, 4}));
}

TEST_F(OverlapCheckerTest, BelowTheLeastOverlapTheStripGoesOnIfThreeImagesShareGround) {
  // 53 % of keyframe 1 are in frame 2; a quarter of keyframe 2 and a sixteenth of keyframe 1 are in frame 3.
  for (const double x : {0, 150, 300}) add_at(x);
  EXPECT_TRUE(run(*checker).empty());
  EXPECT_EQ(keyframes(1), (Frames{1, 2, 3}));
  EXPECT_EQ(decision(3), OverlapDecision::selected);
  EXPECT_NEAR(read<OverlapRecord>(2).overlap, 1 - 150.0 / width, 0.02);
  EXPECT_NEAR(read<KeyframeRecord>(3).overlap, 1 - 150.0 / width, 0.02);
  EXPECT_NEAR(read<KeyframeRecord>(3).plane_from_previous[2], -150, 2);
  EXPECT_EQ(read<StripRecord>(1).end, StripEnd::open);
}

TEST_F(OverlapCheckerTest, WhereTooLittleGroundIsSharedByThreeTheStripEndsAndTheNextBegins) {
  // 47 % of keyframe 2 are in frame 3, but nothing of keyframe 1.
  for (const double x : {0, 160, 330, 350, 395}) add_at(x);
  const std::vector<Status> events = run(*checker);
  EXPECT_EQ(keyframes(1), (Frames{1, 2}));
  EXPECT_EQ(keyframes(2), (Frames{3, 5}));
  EXPECT_EQ(decision(3), OverlapDecision::new_strip);
  EXPECT_EQ(read<StripRecord>(1).end, StripEnd::overlap_lost);
  EXPECT_EQ(read<StripRecord>(2).end, StripEnd::open);
  EXPECT_EQ(read<StripRecord>(2).first_keyframe_id, 3);
  EXPECT_NEAR(read<OverlapRecord>(3).overlap, 1 - 170.0 / width, 0.02);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].code, StatusCode::strip_broken);
  EXPECT_EQ(events[0].a, 1);
  EXPECT_EQ(events[0].b, static_cast<std::int64_t>(StripEnd::overlap_lost));
}

/// As view_at(x), but a cloud with a texture of its own leaves the left quarter.
test::Image cloudy_view_at(double x) {
  test::Image image = test::render_texture(width, height, Similarity2{1, 0, 1000 + x, 2000}, 1, 0, 0, 1);
  const test::Image cloud = test::render_texture(width, height, Similarity2{1, 0, 70'000, 2000}, 1, 0, 0, 1);
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t column = width / 4; column < width; ++column) {
      image.view().at(column, y) = cloud.view().at(column, y);
    }
  }
  return image;
}

TEST_F(OverlapCheckerTest, AcrossAKeyframeInCloudTheFrameIsRelatedToTheOneBefore) {
  add_at(0);
  add_at(60);
  add(cloudy_view_at(120));
  // It shares 20 columns with the clear quarter, and 62 % with keyframe 2.
  add_at(180);
  add_at(240);
  EXPECT_TRUE(run(*checker).empty());
  EXPECT_EQ(keyframes(1), (Frames{1, 2, 3, 4, 5}));
  EXPECT_EQ(decision(4), OverlapDecision::selected);
  EXPECT_EQ(read<OverlapRecord>(4).keyframe_id, 3);
  EXPECT_NEAR(read<OverlapRecord>(4).overlap, 1 - 60.0 / width, 0.03);
  EXPECT_EQ(read<OverlapRecord>(5).keyframe_id, 4);
  double plane[9];
  compose_planes(read<KeyframeRecord>(4).plane_from_previous, read<KeyframeRecord>(3).plane_from_previous, plane);
  const Similarity2 from_second = similarity_at_centre(width, height, plane);
  EXPECT_NEAR(from_second.shift_x_px, -120, 2);
  EXPECT_NEAR(from_second.shift_y_px, 0, 2);
  EXPECT_EQ(number_of<StripRecord>(), 1);
}

TEST_F(OverlapCheckerTest, AcrossAKeyframeInCloudAFrameIsTakenAtOnce) {
  mission.target_overlap = 0.7;
  add_at(0);
  add_at(100);
  add(cloudy_view_at(200));
  // 81 % of keyframe 3, if there were no cloud.
  add_at(260);
  EXPECT_TRUE(run(*checker).empty());
  EXPECT_EQ(keyframes(1), (Frames{1, 2, 3, 4}));
  EXPECT_EQ(decision(4), OverlapDecision::selected);
  EXPECT_NEAR(read<OverlapRecord>(4).overlap, 1 - 60.0 / width, 0.03);
}

TEST_F(OverlapCheckerTest, UnrelatedGroundBehindThreeKeyframesBeginsAStrip) {
  for (const double x : {0.0, 60.0, 120.0, elsewhere_px, elsewhere_px + 20, elsewhere_px + 60}) add_at(x);
  run(*checker);
  EXPECT_EQ(keyframes(1), (Frames{1, 2, 3}));
  EXPECT_EQ(keyframes(2), (Frames{4, 6}));
  EXPECT_EQ(read<StripRecord>(1).end, StripEnd::overlap_unknown);
}

TEST_F(OverlapCheckerTest, WhereTheKeyframeBeforeCannotBeReadTheStripEndsBehindTheCloud) {
  add_at(0);
  add_at(60);
  add(cloudy_view_at(120));
  run(*checker);
  auto before = read<FrameRecord>(2);
  before.image.bytes = 0;
  write(before);
  for (const double x : {180, 200}) add_at(x);
  run(*checker);
  EXPECT_EQ(keyframes(1), (Frames{1, 2, 3}));
  EXPECT_EQ(read<StripRecord>(1).end, StripEnd::overlap_unknown);
  EXPECT_EQ(keyframes(2), (Frames{4}));
}

TEST_F(OverlapCheckerTest, ReadsThatFailAndRestartsBehindACloudChangeNothing) {
  add_at(0);
  add_at(60);
  add(cloudy_view_at(120));
  add_at(180);
  add_at(240);
  test::FailingStore failing(store);
  std::set<std::int64_t> failed;
  failing.judge_by([&](const test::FailingStore::Call& call) {
    // The image of keyframe 2 is read once as the latest one, and once as the one before.
    const bool hit = call.kind == test::StoreCall::read_blob && call.type == RecordType::frame &&
                     number_of<OverlapRecord>() == 3 && failed.insert(call.id).second;
    return hit ? Status{StatusCode::store_error, 10} : Status{};
  });
  for (int boot = 0; boot < 40; ++boot) {
    checker = std::make_unique<OverlapChecker>(failing, mission, test::step_memory<OverlapChecker>());
    ASSERT_TRUE(checker->restore().ok());
    // A frame may take two steps.
    bool pending = checker->step().pending;
    if (boot % 2 == 0) pending = checker->step().pending;
    if (!pending && number_of<OverlapRecord>() == frames) break;
  }
  EXPECT_TRUE(failed.contains(2));
  EXPECT_EQ(keyframes(1), (Frames{1, 2, 3, 4, 5}));
  EXPECT_EQ(number_of<StripRecord>(), 1);
}

TEST_F(OverlapCheckerTest, OrientedFeaturesRelateAFrameThatIsTurnedFartherThanIsSearched) {
  add_at(0);
  // The middle of the image moves by 80 px, and the image is turned about it.
  const double turn = 1.9, c = std::cos(turn), s = std::sin(turn);
  const double x = 1000 + 0.5 * width + 80, y = 2000 + 0.5 * height;
  const Similarity2 ground_from_image{1, turn, x - 0.5 * (c * width - s * height), y - 0.5 * (s * width + c * height)};
  add(test::render_texture(width, height, ground_from_image, 1, 0, 0, 1));
  EXPECT_TRUE(run(*checker).empty());
  EXPECT_EQ(keyframes(1), (Frames{1, 2}));
  EXPECT_NEAR(std::remainder(std::fabs(read<OverlapRecord>(2).rotation_rad) - turn, 2 * pi), 0, 0.02);
  // Pixel (240, 120) of the first image is what the second one shows in its middle.
  const auto plane = read<KeyframeRecord>(2);
  const double* h = plane.plane_from_previous;
  const double w = h[6] * 240 + h[7] * 120 + h[8];
  const double u = (h[0] * 240 + h[1] * 120 + h[2]) / w;
  const double v = (h[3] * 240 + h[4] * 120 + h[5]) / w;
  EXPECT_NEAR(u, 0.5 * width, 2);
  EXPECT_NEAR(v, 0.5 * height, 2);
}

TEST_F(OverlapCheckerTest, DarkBlurredAndBlankFramesAreLeftOutWithAVerdictAndTheStripGoesOn) {
  test::Image dark(width, height);
  std::fill(dark.pixels.begin(), dark.pixels.end(), std::uint8_t{2});
  test::Image blank(width, height);
  std::fill(blank.pixels.begin(), blank.pixels.end(), std::uint8_t{128});
  test::Image blurred(width, height);
  constexpr int reach = 14;
  const test::Image wide = test::render_texture(width + 2 * reach, height, Similarity2{1, 0, 1030, 2000}, 1, 0, 0, 1);
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      int sum = 0;
      for (int k = 0; k <= 2 * reach; ++k) sum += wide.view().at(x + k, y);
      blurred.view().at(x, y) = static_cast<std::uint8_t>(sum / (2 * reach + 1));
    }
  }
  add_at(0);
  add(dark);
  add(blank);
  add(blurred);
  add_at(60);
  const std::vector<Status> events = run(*checker);
  EXPECT_EQ(keyframes(1), (Frames{1, 5}));
  EXPECT_EQ(verdict(2), OverlapVerdict::too_dark);
  EXPECT_EQ(verdict(3), OverlapVerdict::texture_poor);
  EXPECT_EQ(verdict(4), OverlapVerdict::blurred);
  ASSERT_EQ(events.size(), 3U);
  for (std::int64_t frame = 2; frame <= 4; ++frame) {
    EXPECT_EQ(decision(frame), OverlapDecision::rejected);
    const Status& event = events[static_cast<std::size_t>(frame - 2)];
    EXPECT_EQ(event.code, StatusCode::overlap_unknown);
    EXPECT_EQ(event.a, frame);
    EXPECT_EQ(event.b, static_cast<std::int64_t>(verdict(frame)));
  }
  EXPECT_EQ(read<StripRecord>(1).end, StripEnd::open);
}

TEST_F(OverlapCheckerTest, ADarkFrameBeginsNoStrip) {
  test::Image dark(width, height);
  std::fill(dark.pixels.begin(), dark.pixels.end(), std::uint8_t{2});
  add(dark);
  for (const double x : {0, 30, 60}) add_at(x);
  run(*checker);
  EXPECT_EQ(keyframes(1), (Frames{2, 4}));
  EXPECT_EQ(decision(1), OverlapDecision::rejected);
  EXPECT_EQ(verdict(1), OverlapVerdict::too_dark);
}

TEST_F(OverlapCheckerTest, OneFrameOfSomewhereElseDoesNotEndTheStrip) {
  for (const double x : {0.0, elsewhere_px, 20.0, 60.0}) add_at(x);
  run(*checker);
  EXPECT_EQ(keyframes(1), (Frames{1, 4}));
  EXPECT_EQ(decision(2), OverlapDecision::rejected);
  EXPECT_EQ(verdict(2), OverlapVerdict::overlap_unknown);
  EXPECT_EQ(number_of<StripRecord>(), 1);
}

TEST_F(OverlapCheckerTest, TwoUnrelatedFramesInARowBeginAStripAtTheFirstOfThem) {
  for (const double x : {0.0, elsewhere_px, elsewhere_px + 20, elsewhere_px + 60}) add_at(x);
  run(*checker);
  EXPECT_EQ(keyframes(1), (Frames{1}));
  EXPECT_EQ(keyframes(2), (Frames{2, 4}));
  EXPECT_EQ(read<StripRecord>(1).end, StripEnd::overlap_unknown);
  EXPECT_EQ(decision(3), OverlapDecision::skipped);
  EXPECT_NEAR(read<OverlapRecord>(3).overlap, 1 - 20.0 / width, 0.01);
}

TEST_F(OverlapCheckerTest, BeforeABreakTheLastGroundOfTheStripIsTakenIn) {
  for (const double x : {0.0, 40.0, elsewhere_px, elsewhere_px + 60}) add_at(x);
  run(*checker);
  EXPECT_EQ(keyframes(1), (Frames{1, 2}));
  EXPECT_EQ(keyframes(2), (Frames{3, 4}));
}

TEST_F(OverlapCheckerTest, TheEndOfTheFlightTakesTheLastGround) {
  add_at(0);
  add_at(30);
  command(StripEnd::end_of_flight);
  EXPECT_TRUE(run(*checker).empty()) << "an end that was asked for is no event";
  EXPECT_EQ(keyframes(1), (Frames{1, 2}));
  EXPECT_EQ(read<StripRecord>(1).end, StripEnd::end_of_flight);
  EXPECT_EQ(read<StripRecord>(1).last_keyframe_id, 2);
}

TEST_F(OverlapCheckerTest, ALastFrameThatShowsNextToNothingNewIsNotTaken) {
  add_at(0);
  add_at(8);
  command(StripEnd::end_of_flight);
  run(*checker);
  EXPECT_EQ(keyframes(1), (Frames{1}));
  EXPECT_EQ(read<StripRecord>(1).end, StripEnd::end_of_flight);
}

TEST_F(OverlapCheckerTest, ALastFrameOfSomewhereElseIsNotLost) {
  for (const double x : {0.0, 60.0, elsewhere_px}) add_at(x);
  command(StripEnd::end_of_flight);
  run(*checker);
  EXPECT_EQ(keyframes(1), (Frames{1, 2}));
  EXPECT_EQ(keyframes(2), (Frames{3}));
  EXPECT_EQ(read<StripRecord>(1).end, StripEnd::overlap_unknown);
  EXPECT_EQ(read<StripRecord>(2).end, StripEnd::end_of_flight);
}

TEST_F(OverlapCheckerTest, ACommandWaitsForTheFramesBeforeIt) {
  for (const double x : {0, 60, 120}) add_at(x);
  command(StripEnd::commanded);
  for (const double x : {125, 180}) add_at(x);
  run(*checker);
  EXPECT_EQ(keyframes(1), (Frames{1, 2, 3}));
  EXPECT_EQ(read<StripRecord>(1).end, StripEnd::commanded);
  EXPECT_EQ(keyframes(2), (Frames{4})) << "the first frame behind the command";
}

TEST_F(OverlapCheckerTest, AfterALostPoseTheStripEndsWithoutAFurtherKeyframe) {
  add_at(0);
  add_at(30);
  command(StripEnd::pose_lost);
  run(*checker);
  EXPECT_EQ(keyframes(1), (Frames{1}));
  EXPECT_EQ(read<StripRecord>(1).end, StripEnd::pose_lost);
}

TEST_F(OverlapCheckerTest, AFrameThatCannotBeReadIsPassedOver) {
  add_at(0);
  FrameRecord released;
  released.id = ++frames;
  released.width = width;
  released.height = height;
  write(released);
  add_at(60);
  const std::vector<Status> events = run(*checker);
  EXPECT_EQ(keyframes(1), (Frames{1, 3}));
  EXPECT_EQ(decision(2), OverlapDecision::rejected);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].code, StatusCode::not_found);
}

TEST_F(OverlapCheckerTest, WhereTheKeyframeCannotBeReadTheStripEndsAndTheNextFrameBeginsAnother) {
  add_at(0);
  EXPECT_TRUE(run(*checker).empty());
  auto keyframe = read<FrameRecord>(1);
  keyframe.image.bytes = 0;
  write(keyframe);
  // The image is in no memory any more.
  checker = std::make_unique<OverlapChecker>(store, mission, test::step_memory<OverlapChecker>());
  ASSERT_TRUE(checker->restore().ok());
  for (const double x : {20, 40, 80}) add_at(x);
  const std::vector<Status> events = run(*checker);
  ASSERT_FALSE(events.empty());
  EXPECT_EQ(events.back().code, StatusCode::strip_broken);
  EXPECT_EQ(read<StripRecord>(1).end, StripEnd::overlap_lost);
  EXPECT_EQ(decision(2), OverlapDecision::new_strip);
  EXPECT_EQ(keyframes(2), (Frames{2, 4}));
}

TEST_F(OverlapCheckerTest, AReadThatFailsOnceCostsNoFrame) {
  test::FailingStore failing(store);
  std::set<std::int64_t> failed;
  failing.judge_by([&](const test::FailingStore::Call& call) {
    const bool image = call.kind == test::StoreCall::read_blob && call.type == RecordType::frame;
    const bool hit = image && failed.insert(call.id).second;
    return hit ? Status{StatusCode::store_error, 10} : Status{};
  });
  checker = std::make_unique<OverlapChecker>(failing, mission, test::step_memory<OverlapChecker>());
  ASSERT_TRUE(checker->restore().ok());
  for (const double x : {0, 20, 40, 60, 80, 100, 121}) add_at(x);
  run(*checker);
  EXPECT_EQ(failed.size(), 7U);
  EXPECT_EQ(keyframes(1), (Frames{1, 4, 7}));
  for (std::int64_t frame = 1; frame <= 7; ++frame) EXPECT_NE(decision(frame), OverlapDecision::rejected) << frame;
}

TEST_F(OverlapCheckerTest, BehindADamagedCheckpointNothingIsChosenTwice) {
  for (const bool newer_only : {true, false}) {
    SCOPED_TRACE(newer_only);
    const double begin = newer_only ? 0 : 500;
    for (const double x : {0, 20, 40, 60}) add_at(begin + x);
    run(*checker);
    const std::int64_t chosen = number_of<KeyframeRecord>();
    damage_checkpoints(newer_only);
    checker = std::make_unique<OverlapChecker>(store, mission, test::step_memory<OverlapChecker>());
    EXPECT_EQ(checker->restore().code, newer_only ? StatusCode::checkpoint_older : StatusCode::checkpoint_lost);
    const auto before = read<KeyframeRecord>(chosen);
    const std::int64_t strips = number_of<StripRecord>();
    for (const double x : {80, 100, 121}) add_at(begin + x);
    run(*checker);
    EXPECT_EQ(read<KeyframeRecord>(chosen).frame_id, before.frame_id);
    EXPECT_EQ(read<StripRecord>(strips).end, StripEnd::overlap_lost);
    EXPECT_EQ(number_of<OverlapRecord>(), frames) << "every frame once";
    EXPECT_GT(number_of<KeyframeRecord>(), chosen) << "it goes on";
    command(StripEnd::commanded);
    run(*checker);
  }
}

TEST_F(OverlapCheckerTest, ADamagedStripRecordIsMadeAnew) {
  for (const double x : {0, 60}) add_at(x);
  run(*checker);
  const auto wanted = read<StripRecord>(1);
  test::FailingStore failing(store);
  bool damaged = true;
  failing.judge_by([&](const test::FailingStore::Call& call) {
    const bool hit = damaged && call.kind == test::StoreCall::get && call.type == RecordType::strip;
    if (call.kind == test::StoreCall::put && call.type == RecordType::strip) damaged = false;
    return hit ? Status{StatusCode::record_damaged, call.id, static_cast<std::int64_t>(call.type)} : Status{};
  });
  checker = std::make_unique<OverlapChecker>(failing, mission, test::step_memory<OverlapChecker>());
  ASSERT_TRUE(checker->restore().ok());
  add_at(120);
  run(*checker);
  const auto strip = read<StripRecord>(1);
  EXPECT_EQ(strip.first_keyframe_id, wanted.first_keyframe_id);
  EXPECT_EQ(strip.last_keyframe_id, 3);
  EXPECT_EQ(strip.end, StripEnd::open);
}

TEST_F(OverlapCheckerTest, ASteepDescentStaysWithinTheScalesThatCanBeSearched) {
  mission.target_overlap = 0.45;
  mission.min_overlap = 0.35;
  for (mission.max_scale = 1.05; mission.max_scale < 1.5; mission.max_scale += 0.01) {
    add_at(elsewhere_px * static_cast<double>(frames));
    const std::int64_t first = frames;
    for (const double scale : {1.05, 1.16, 1.27, 1.38, 1.46, 1.5}) {
      const double x = 1000 + elsewhere_px * static_cast<double>(first - 1);
      add(test::render_texture(width, height, Similarity2{1 / scale, 0, x, 2000}, 1, 0, 0, 1));
    }
    for (const Status& status : run(*checker)) {
      EXPECT_FALSE(status.is(StatusCode::invalid_argument)) << "max_scale " << mission.max_scale;
    }
  }
}

TEST_F(OverlapCheckerTest, AClimbThatLeavesTheKeyframeInViewTakesAFrameOfWhichMuchIsNew) {
  // All of the keyframe stays in view. Of the frames 8, 14, 26 and 31 % are new; 27 % is half as much again as planned.
  for (const double scale : {1.0, 1.04, 1.08, 1.16, 1.2}) {
    const double x = 1000 + 0.5 * width * (1 - scale), y = 2000 + 0.5 * height * (1 - scale);
    add(test::render_texture(width, height, Similarity2{scale, 0, x, y}, 1, 0, 0, 1));
  }
  EXPECT_TRUE(run(*checker).empty());
  EXPECT_EQ(keyframes(1), (Frames{1, 5}));
  EXPECT_EQ(decision(4), OverlapDecision::skipped);
  EXPECT_GT(read<KeyframeRecord>(2).overlap, 0.97);
}

TEST_F(OverlapCheckerTest, ACameraThatGoesAroundItsSubjectTakesFramesBetweenTheViews) {
  for (const double turn : {0.0, 0.15, 0.3, 0.5, 0.62, 0.75}) add(view_turned_by(turn));
  EXPECT_TRUE(run(*checker).empty());
  // Between the fourth frame and the first one the distances of the borders change by factors that differ by 1.67,
  // between the sixth one and the third one by 1.63. The frames before them lie between these views.
  EXPECT_EQ(keyframes(1), (Frames{1, 3, 5}));
  EXPECT_GT(read<KeyframeRecord>(2).overlap, 0.85);
  EXPECT_EQ(read<OverlapRecord>(4).keyframe_id, 2);
  EXPECT_EQ(decision(4), OverlapDecision::skipped);
}

TEST_F(OverlapCheckerTest, AViewThatHasTurnedAtOnceIsTakenItself) {
  for (const double turn : {0.0, 0.01, 0.5}) add(view_turned_by(turn));
  EXPECT_TRUE(run(*checker).empty());
  EXPECT_EQ(keyframes(1), (Frames{1, 3}));
}

TEST_F(OverlapCheckerTest, RestartedAtEveryStepItDecidesTheSame) {
  for (const double x : {0.0, 40.0, 180.0, 200.0, elsewhere_px, elsewhere_px + 20, elsewhere_px + 50}) add_at(x);
  command(StripEnd::end_of_flight);
  for (int boot = 0; boot < 40; ++boot) {
    checker = std::make_unique<OverlapChecker>(store, mission, test::step_memory<OverlapChecker>());
    ASSERT_TRUE(checker->restore().ok());
    // A frame that is unrelated takes two steps.
    if (!checker->step().pending) break;
    if (boot % 2 == 1 && !checker->step().pending) break;
  }
  EXPECT_EQ(keyframes(1), (Frames{1, 2, 3, 4}));
  EXPECT_EQ(keyframes(2), (Frames{5, 7}));
  EXPECT_EQ(read<StripRecord>(1).end, StripEnd::overlap_unknown);
  EXPECT_EQ(read<StripRecord>(2).end, StripEnd::end_of_flight);
  EXPECT_EQ(number_of<OverlapRecord>(), 7);
}

}  // namespace
}  // namespace ilp
