#include "fsw/imaging/capture_clock.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>

#include "fsw/base/math.hpp"
#include "tests/support/failing_store.hpp"
#include "tests/unit/imaging/capture_fixture.hpp"

namespace ilp {
namespace {

constexpr std::int32_t width = 640;
constexpr std::int32_t height = 480;

using test::at_s;

/// Plays acquisition and overlap checker: a camera that moves along the image's rows.
class CaptureClockTest : public test::CaptureFixture {
 protected:
  CaptureClockTest() {
    mission.capture_mode = CaptureMode::forecast;
    mission.capture_min_interval_s = 0.5;
    mission.capture_safe_interval_s = 2;
    mission.capture_max_interval_s = 60;
    planner = std::make_unique<CaptureClock>(store, camera, clock, mission);
    EXPECT_TRUE(planner->restore().ok());
  }

  [[nodiscard]] CaptureRecord latest() {
    CaptureRecord capture;
    EXPECT_TRUE(last(store, capture).ok());
    return capture;
  }
  void step_at(double seconds) {
    clock.set(at_s(seconds));
    faults = run(*planner);
  }
  /// The pending capture is exposed at its time, at `x` pixels along the way, and its overlap is recorded.
  void expose(CaptureRecord capture, double x, bool answer = true) {
    clock.set(capture.requested_ns);
    FrameRecord frame;
    frame.id = ++frames;
    frame.time_ns = capture.requested_ns;
    frame.width = width;
    frame.height = height;
    frame.capture_id = capture.id;
    write(frame);
    capture.state = CaptureState::exposed;
    capture.frame_id = frame.id;
    capture.exposed_ns = frame.time_ns;
    write(capture);
    if (answer) report_overlap(x);
  }
  void report_overlap(double x) {
    const auto frame = read<FrameRecord>(frames);
    OverlapRecord overlap;
    overlap.id = frame.id;
    overlap.keyframe_id = keyframes;
    overlap.shift_x_px = keyframe_x - x;
    overlap.overlap = 1 - (x - keyframe_x) / width;
    const bool first = keyframes == 0;
    const bool chosen = overlap.overlap <= mission.target_overlap + 0.02;
    overlap.decision = first    ? OverlapDecision::new_strip
                       : chosen ? OverlapDecision::selected
                                : OverlapDecision::skipped;
    if (first || chosen) {
      KeyframeRecord keyframe;
      keyframe.id = ++keyframes;
      keyframe.frame_id = frame.id;
      keyframe.time_ns = frame.time_ns;
      write(keyframe);
      keyframe_x = x;
    }
    write(overlap);
  }
  std::int64_t command_capture(double seconds) {
    CommandRecord command{.kind = CommandKind::capture, .at_ns = at_s(seconds)};
    return send(command);
  }
  CaptureRecord of_command(std::int64_t command) {
    const CaptureRecord capture = CaptureFixture::of_command(command);
    EXPECT_EQ(capture.command_id, command) << "it has no capture";
    return capture;
  }

  std::int64_t frames = 0;
  double keyframe_x = 0;
};

TEST_F(CaptureClockTest, RegularModeKeepsTheInterval) {
  mission.capture_mode = CaptureMode::regular;
  mission.capture_interval_s = 2;
  for (const double expected : {10.0, 12.0, 14.0}) {
    step_at(expected - (expected > 10 ? 1.9 : 0));
    EXPECT_EQ(latest().requested_ns, at_s(expected));
    EXPECT_EQ(latest().source, CaptureSource::regular);
    expose(latest(), 0);
  }
  // Late by several intervals: the rhythm stays, nothing is made up for.
  step_at(21.5);
  EXPECT_EQ(latest().requested_ns, at_s(22));
  EXPECT_EQ(number_of<CaptureRecord>(), 4);
}

TEST_F(CaptureClockTest, AnIntervalBelowANanosecondEndsNothing) {
  mission.capture_mode = CaptureMode::regular;
  // Refused by validate(); a bit may flip in memory all the same.
  for (const double interval_s : {1e-10, 5e-324, 1e-9}) {
    mission.capture_interval_s = interval_s;
    for (int k = 0; k < 3; ++k) {
      step_at(1 + 1e-9 * static_cast<double>(clock.now()));
      expose(latest(), 0);
    }
  }
  EXPECT_GE(number_of<CaptureRecord>(), 3);
}

TEST_F(CaptureClockTest, EveryFrameModeAsksForNothing) {
  mission.capture_mode = CaptureMode::regular;
  mission.capture_interval_s = 0;
  step_at(5);
  EXPECT_EQ(number_of<CaptureRecord>(), 0);
}

TEST_F(CaptureClockTest, AfterTwoFramesTheTimeOfTheTargetOverlapIsForecast) {
  mission.capture_max_sigma = 1;
  constexpr double speed = 11;  // px/s
  step_at(1);
  EXPECT_EQ(latest().source, CaptureSource::safe);
  EXPECT_EQ(latest().requested_ns, at_s(1)) << "at once";
  expose(latest(), 0);
  step_at(1.1);
  EXPECT_EQ(latest().source, CaptureSource::safe) << "one frame tells no motion";
  EXPECT_EQ(latest().requested_ns, at_s(3));
  expose(latest(), 2 * speed);
  step_at(3.1);
  EXPECT_EQ(latest().source, CaptureSource::forecast);
  EXPECT_NEAR(static_cast<double>(latest().requested_ns), 1e9 * (1 + 0.18 * width / speed), 1e7);
  EXPECT_NEAR(latest().overlap, 0.82, 1e-4);
  EXPECT_NEAR(latest().speed_px_s, speed, 0.01);
  // From then on one frame a keyframe.
  for (int k = 0; k < 5; ++k) {
    const std::int64_t before = keyframes;
    const double x = speed * (1e-9 * static_cast<double>(latest().requested_ns) - 1);
    expose(latest(), x);
    EXPECT_EQ(keyframes, before + 1);
    step_at(1e-9 * static_cast<double>(clock.now()) + 0.1);
  }
}

TEST_F(CaptureClockTest, ADoubtfulForecastTakesAFrameOnTheWay) {
  mission.capture_max_sigma = 0.02;  // two places leave the gusts open
  step_at(1);
  expose(latest(), 0);
  step_at(1.1);
  expose(latest(), 20);
  step_at(3.1);
  EXPECT_EQ(latest().source, CaptureSource::on_the_way);
  EXPECT_LT(latest().requested_ns, at_s(1 + 0.18 * width / 10));
  EXPECT_GT(latest().overlap, 0.82);
}

TEST_F(CaptureClockTest, WaitsForTheOverlapAndGoesOnWithoutItAfterTheSafeInterval) {
  step_at(1);
  expose(latest(), 0);
  step_at(1.1);
  expose(latest(), 20, false);
  step_at(4);
  EXPECT_EQ(number_of<CaptureRecord>(), 2) << "the answer may come any moment";
  step_at(5.1);
  ASSERT_EQ(number_of<CaptureRecord>(), 3);
  EXPECT_EQ(latest().source, CaptureSource::safe);
  EXPECT_EQ(latest().requested_ns, at_s(5.1));
}

TEST_F(CaptureClockTest, InHoverItWaitsForTheLongestIntervalAndNoLonger) {
  step_at(1);
  expose(latest(), 0);
  step_at(1.1);
  expose(latest(), 0);
  step_at(3.1);
  EXPECT_EQ(latest().requested_ns, at_s(3 + 60));
}

TEST_F(CaptureClockTest, ATelecommandedTimeIsOnRecordAndComesFirst) {
  mission.capture_mode = CaptureMode::telecommanded;
  step_at(1);
  EXPECT_EQ(number_of<CaptureRecord>(), 0) << "this mode has no times of its own";
  const std::int64_t command = command_capture(4.25);
  step_at(1.1);
  const CaptureRecord capture = of_command(command);
  EXPECT_EQ(capture.source, CaptureSource::telecommand);
  EXPECT_EQ(capture.state, CaptureState::pending);
  EXPECT_EQ(capture.requested_ns, at_s(4.25));
}

TEST_F(CaptureClockTest, APastTimeIsRejectedAndReportedAndThePresentOneIsNot) {
  mission.capture_mode = CaptureMode::telecommanded;
  clock.set(at_s(10));
  const std::int64_t past = command_capture(9.999);
  step_at(10);
  EXPECT_EQ(of_command(past).state, CaptureState::rejected);
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].code, StatusCode::capture_in_past);
  EXPECT_EQ(faults[0].a, past);
  EXPECT_EQ(faults[0].b, 1000) << "microseconds";
  const std::int64_t now = command_capture(10);
  step_at(10);
  EXPECT_EQ(of_command(now).state, CaptureState::pending);
  EXPECT_TRUE(faults.empty());
}

TEST_F(CaptureClockTest, CommandsNearerThanTheCameraCanAreRejectedAndReported) {
  mission.capture_mode = CaptureMode::telecommanded;
  clock.set(at_s(1));
  const std::int64_t first = command_capture(5);
  const std::int64_t too_soon = command_capture(5.499);
  const std::int64_t second = command_capture(5.5);
  step_at(1);
  EXPECT_EQ(of_command(first).state, CaptureState::pending);
  EXPECT_EQ(of_command(too_soon).state, CaptureState::rejected);
  EXPECT_EQ(of_command(second).state, CaptureState::pending);
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].code, StatusCode::capture_too_soon);
  EXPECT_EQ(faults[0].a, too_soon);
}

TEST_F(CaptureClockTest, MoreTelecommandsThanItCanHoldAreRefusedNotForgotten) {
  mission.capture_mode = CaptureMode::telecommanded;
  clock.set(at_s(1));
  std::int64_t command = 0;
  for (std::size_t k = 0; k <= CaptureClock::max_telecommanded; ++k) command = command_capture(5.0 + double(k));
  step_at(1);
  EXPECT_EQ(of_command(command).state, CaptureState::rejected);
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].code, StatusCode::capacity_exceeded);
  // What has been exposed makes room.
  CaptureRecord done = of_command(1);
  expose(done, 0);
  step_at(5.1);
  const std::int64_t again = command_capture(100);
  step_at(5.2);
  EXPECT_EQ(of_command(again).state, CaptureState::pending);
}

TEST_F(CaptureClockTest, ATelecommandReplacesAForecastTimeThatIsTooNear) {
  mission.capture_max_sigma = 1;
  step_at(1);
  expose(latest(), 0);
  step_at(1.1);
  expose(latest(), 20);
  step_at(3.1);
  const CaptureRecord own = latest();
  ASSERT_EQ(own.source, CaptureSource::forecast);
  const std::int64_t command = command_capture(1e-9 * static_cast<double>(own.requested_ns) + 0.2);
  step_at(3.2);
  EXPECT_EQ(read<CaptureRecord>(own.id).state, CaptureState::superseded);
  EXPECT_EQ(of_command(command).state, CaptureState::pending);
  EXPECT_EQ(latest().id, of_command(command).id) << "and no other is planned beside it";
}

/// A gondola on a long tether that gusts push: where its camera looks, px of the first image, beside a drift.
class Swing {
 public:
  Swing() {
    constexpr double frequency = 2 * pi / 21, damping = 0.03, kick = 3;
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    double place = 20, rate = 0;
    for (double& px : px_) {
      rate += step_s * (-frequency * frequency * place - 2 * damping * frequency * rate) +
              std::sqrt(step_s) * kick * frequency * normal(random);
      place += step_s * rate;
      px = place;
    }
  }
  [[nodiscard]] double at(double seconds) const {
    const double steps = seconds / step_s;
    const auto i = static_cast<std::size_t>(steps);
    return px_.at(i) + (steps - static_cast<double>(i)) * (px_.at(i + 1) - px_.at(i));
  }

 private:
  static constexpr double step_s = 0.05;
  std::array<double, 20'000> px_{};
};

TEST_F(CaptureClockTest, APoseTellsTheSwingAndATimeForecastWithoutItGivesWay) {
  const Swing swing;
  CameraRecord lens{.fx = 550, .fy = 550};
  write(lens);
  const auto report_pose = [&](std::int64_t id) {
    const double seconds = 1e-9 * static_cast<double>(read<KeyframeRecord>(id).time_ns);
    // The axis at an angle about y: cam_from_world turns back by it.
    const double half = -0.5 * det_atan2(swing.at(seconds) - swing.at(1), lens.fx);
    PoseRecord pose{.id = id};
    pose.q_cam_from_world[0] = det_cos(half);
    pose.q_cam_from_world[2] = det_sin(half);
    write(pose);
  };
  const auto place = [&](double seconds) { return 12 * seconds + swing.at(seconds); };
  const auto requested_s = [&] { return 1e-9 * static_cast<double>(latest().requested_ns); };
  step_at(1);
  double squares = 0;
  int superseded = 0;
  for (int frame = 0; frame < 60; ++frame) {
    const std::int64_t before = keyframes;
    expose(latest(), place(requested_s()));
    step_at(1e-9 * static_cast<double>(clock.now()) + 0.1);
    const CaptureRecord without = latest();
    if (keyframes == before) continue;
    report_pose(keyframes);
    step_at(1e-9 * static_cast<double>(clock.now()) + 0.1);
    if (frame < 12 || latest().id == without.id) continue;
    EXPECT_EQ(read<CaptureRecord>(without.id).state, CaptureState::superseded);
    EXPECT_EQ(latest().state, CaptureState::pending);
    const double way = place(requested_s()) - keyframe_x;
    const double error = 1 - way / width - latest().overlap;
    squares += error * error;
    ++superseded;
  }
  ASSERT_GT(superseded, 10);
  // The swing alone moves the image by 2.5 % of its width; without attitudes this flight's forecasts are 6 % off.
  EXPECT_LT(std::sqrt(squares / superseded), 0.02);
}

TEST_F(CaptureClockTest, APoseInRegularModeChangesNothing) {
  mission.capture_mode = CaptureMode::regular;
  mission.capture_interval_s = 2;
  step_at(10);
  expose(latest(), 0);
  step_at(10.1);
  const std::int64_t captures = number_of<CaptureRecord>();
  PoseRecord pose{.id = keyframes};
  write(pose);
  step_at(10.2);
  EXPECT_EQ(number_of<CaptureRecord>(), captures);
  EXPECT_EQ(latest().state, CaptureState::pending);
}

/// Captures in a regular interval of 4 s, while a minor frame follows the other.
class BurstTest : public CaptureClockTest {
 protected:
  BurstTest() {
    mission.capture_mode = CaptureMode::regular;
    mission.capture_interval_s = 4;
  }
  void report_readout(double seconds) {
    CameraRecord lens{.readout_s = seconds};
    write(lens);
  }
  /// Each capture is exposed at its time.
  void fly(double from_s, double to_s) {
    for (double t = from_s; t < to_s; t += 0.1) {
      step_at(t);
      CaptureRecord capture;
      for (std::int64_t id = 0; next(store, id, capture).ok(); id = capture.id) {
        if (capture.state != CaptureState::pending || capture.requested_ns > clock.now()) continue;
        const TimeNs now = clock.now();
        expose(capture, 0);
        clock.set(now);
      }
    }
  }
  /// Requested times of the captures that became an image, s, in order.
  [[nodiscard]] std::vector<double> times(CaptureSource source) {
    std::vector<double> found;
    for (const CaptureRecord& capture : test::records_of<CaptureRecord>(store)) {
      if (capture.source == source && capture.state == CaptureState::exposed)
        found.push_back(1e-9 * static_cast<double>(capture.requested_ns));
    }
    std::sort(found.begin(), found.end());
    return found;
  }
};

TEST_F(BurstTest, OfARollingShutterShowsTheMotionAboutEachImage) {
  report_readout(0.03);
  fly(10, 20);
  const std::vector<double> images = times(CaptureSource::regular), beside = times(CaptureSource::burst);
  ASSERT_EQ(images, (std::vector<double>{10, 14, 18}));
  ASSERT_EQ(beside.size(), 10U) << "nothing lies before the first one";
  const std::vector<double> expected{10.5, 11, 13, 13.5, 14.5, 15, 17, 17.5, 18.5, 19};
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(beside[i], expected[i], 1e-6) << i;
}

TEST_F(BurstTest, IsAsShortAsTheCameraAllows) {
  mission.capture_min_interval_s = 0.05;
  report_readout(-0.03);
  fly(10, 15);
  const std::vector<double> beside = times(CaptureSource::burst);
  ASSERT_EQ(beside.size(), 6U);
  const std::vector<double> expected{10.15, 10.3, 13.7, 13.85, 14.15, 14.3};
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(beside[i], expected[i], 1e-6) << i;
}

TEST_F(BurstTest, IsNotTakenWhereNothingNeedsIt) {
  fly(10, 15);
  EXPECT_TRUE(times(CaptureSource::burst).empty()) << "all rows at once";
  report_readout(0.03);
  mission.capture_burst = false;
  fly(15, 20);
  EXPECT_TRUE(times(CaptureSource::burst).empty()) << "not wanted";
  mission.capture_burst = true;
  mission.capture_interval_s = 1;
  fly(20, 25);
  EXPECT_TRUE(times(CaptureSource::burst).empty()) << "frequent images show the motion";
  EXPECT_EQ(times(CaptureSource::regular), (std::vector<double>{10, 14, 18, 22, 23, 24}));
}

TEST_F(BurstTest, GivesWayToATelecommandAndIsTakenAboutItsImage) {
  report_readout(0.03);
  fly(10, 13);
  const std::int64_t command = command_capture(14.8);
  fly(13, 18.5);
  EXPECT_EQ(of_command(command).state, CaptureState::exposed);
  const std::vector<double> beside = times(CaptureSource::burst);
  for (const double t : beside) {
    EXPECT_GE(std::fabs(t - 14.8), 0.5 - 1e-6) << t;
    EXPECT_GE(std::fabs(t - 14), 0.5 - 1e-6) << t;
  }
  const auto taken_at = [&](double t) {
    return std::any_of(beside.begin(), beside.end(), [&](double x) { return std::fabs(x - t) < 1e-6; });
  };
  EXPECT_TRUE(taken_at(13) && taken_at(13.5)) << "before the image of 14 s";
  EXPECT_TRUE(taken_at(15.3) && taken_at(15.8)) << "behind the telecommanded one";
  for (std::size_t i = 1; i < beside.size(); ++i) EXPECT_GE(beside[i] - beside[i - 1], 0.5 - 1e-6);
}

TEST_F(CaptureClockTest, AfterARestartItGoesOnAsIfNothingHadHappened) {
  mission.capture_max_sigma = 1;
  step_at(1);
  expose(latest(), 0);
  step_at(1.1);
  expose(latest(), 20);
  auto restarted = std::make_unique<CaptureClock>(store, camera, clock, mission);
  ASSERT_TRUE(restarted->restore().ok());
  planner = std::move(restarted);
  step_at(3.1);
  EXPECT_EQ(latest().source, CaptureSource::forecast);
  EXPECT_EQ(latest().id, 3);
  EXPECT_NEAR(static_cast<double>(latest().requested_ns), 1e9 * (1 + 0.18 * width / 10), 1e7);
}

TEST_F(CaptureClockTest, ACameraThatRunsFreelyBeginsTheRhythm) {
  camera.is_triggered = false;
  mission.capture_mode = CaptureMode::regular;
  mission.capture_interval_s = 3;
  step_at(100);
  EXPECT_EQ(number_of<CaptureRecord>(), 0);
  FrameRecord frame;
  frame.id = ++frames;
  frame.time_ns = at_s(100.4);
  write(frame);
  step_at(100.5);
  EXPECT_EQ(latest().requested_ns, at_s(103.4));
}

TEST_F(CaptureClockTest, AnImageThatIsWantedSoonIsTakenAtOnceWhereItsTimeHasPassed) {
  mission.capture_mode = CaptureMode::telecommanded;
  clock.set(at_s(10));
  CommandRecord command{.id = 1, .kind = CommandKind::capture_soon, .at_ns = at_s(9.9)};
  write(command);
  step_at(10);
  EXPECT_TRUE(faults.empty());
  EXPECT_EQ(of_command(1).state, CaptureState::pending);
  EXPECT_EQ(of_command(1).requested_ns, at_s(10));
  command.id = 2;
  command.at_ns = at_s(10.1);
  write(command);
  step_at(10);
  EXPECT_EQ(of_command(2).state, CaptureState::rejected);
  EXPECT_EQ(of_command(2).reason, static_cast<std::uint16_t>(StatusCode::capture_too_soon));
}

TEST_F(CaptureClockTest, InSafeModeImagesAreWantedAtTheSafeIntervalOnly) {
  mission.capture_mode = CaptureMode::forecast;
  mission.safe_mode = 1;
  double x = 0;
  step_at(0);
  for (int i = 0; i < 5; ++i) {
    const CaptureRecord capture = latest();
    EXPECT_EQ(capture.source, CaptureSource::regular);
    EXPECT_EQ(capture.requested_ns, at_s(2.0 * i)) << i;
    expose(capture, x += 30);
    step_at(2.0 * i + 0.1);
  }
}

TEST_F(CaptureClockTest, BehindADamagedCheckpointNoCaptureIsOverwrittenAndImagesGoOn) {
  mission.capture_mode = CaptureMode::regular;
  mission.capture_interval_s = 2;
  step_at(1);
  for (const bool newer_only : {true, false}) {
    SCOPED_TRACE(newer_only);
    for (int i = 0; i < 3; ++i) {
      expose(latest(), 0);
      step_at(1e-9 * static_cast<double>(clock.now()) + 0.1);
    }
    const std::vector<std::int64_t> asked{latest().id, latest().requested_ns};
    damage_checkpoints(newer_only);
    planner = std::make_unique<CaptureClock>(store, camera, clock, mission);
    EXPECT_EQ(planner->restore().code, newer_only ? StatusCode::checkpoint_older : StatusCode::checkpoint_lost);
    step_at(1e-9 * static_cast<double>(clock.now()) + 0.1);
    EXPECT_EQ(read<CaptureRecord>(asked[0]).requested_ns, asked[1]);
    EXPECT_GT(latest().id, asked[0] - 1);
    expose(latest(), 0);
    step_at(1e-9 * static_cast<double>(clock.now()) + 0.1);
    EXPECT_EQ(latest().state, CaptureState::pending) << "the next one is wanted";
  }
}

TEST_F(CaptureClockTest, ADamagedRecordKeepsItFromNothing) {
  mission.capture_mode = CaptureMode::regular;
  mission.capture_interval_s = 2;
  test::FailingStore failing(store);
  failing.judge_by([&](const test::FailingStore::Call& call) {
    const bool kind =
        call.kind == test::StoreCall::get && (call.type == RecordType::keyframe || call.type == RecordType::frame);
    const bool newest = call.kind == test::StoreCall::last && call.type == RecordType::keyframe;
    return kind || newest ? Status{StatusCode::record_damaged, 1, static_cast<std::int64_t>(call.type)} : Status{};
  });
  planner = std::make_unique<CaptureClock>(failing, camera, clock, mission);
  ASSERT_TRUE(planner->restore().ok());
  step_at(1);
  for (std::int64_t wanted = 2; wanted <= 4; ++wanted) {
    expose(latest(), 0);
    step_at(1e-9 * static_cast<double>(clock.now()) + 0.1);
    EXPECT_EQ(latest().id, wanted);
  }
}

TEST_F(CaptureClockTest, ImagesThatCouldNotBePlannedBecauseOfTheLockAreCounted) {
  mission.capture_mode = CaptureMode::regular;
  mission.capture_interval_s = 2;
  test::FailingStore failing(store);
  planner = std::make_unique<CaptureClock>(failing, camera, clock, mission);
  ASSERT_TRUE(planner->restore().ok());
  step_at(1);
  expose(latest(), 0);
  failing.lock();
  for (int k = 11; k < 105; ++k) {
    clock.set(at_s(0.1 * k));
    EXPECT_EQ(planner->step().status.code, StatusCode::store_locked) << k;
  }
  failing.recover();
  step_at(10.5);
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].code, StatusCode::images_lost);
  EXPECT_EQ(faults[0].a, 4) << "those of 3, 5, 7 and 9 s";
  EXPECT_EQ(latest().requested_ns, at_s(11));
}

}  // namespace
}  // namespace ilp
