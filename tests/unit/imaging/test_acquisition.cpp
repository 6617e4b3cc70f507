#include "fsw/imaging/acquisition.hpp"

#include <algorithm>
#include <cstring>
#include <deque>
#include <memory>
#include <optional>

#include "tests/support/failing_store.hpp"
#include "tests/unit/shared/component_fixture.hpp"

namespace ilp {
namespace {

TimeNs at_s(double seconds) {
  return static_cast<TimeNs>(seconds * 1e9 + 0.5);
}

constexpr std::uint8_t black = 0;

/// Gives what the test puts into it, once the time has come.
class ScriptedCamera final : public Camera {
 public:
  struct Shot {
    TimeNs arrives_ns = 0;
    CameraFrame frame;
    std::uint8_t content = 0;
  };
  Status capture(TimeNs now, FrameImage& image, CameraFrame& frame) override {
    if (is_unasked && trigger_ns && *trigger_ns == any_time) {
      while (regular_ns <= now) {
        shots.push_back({now, {.time_ns = regular_ns, .sequence = ++exposures}, next_content++});
        regular_ns += 2 * ns_per_s;
      }
    }
    if (is_triggered && trigger_ns && *trigger_ns != any_time && *trigger_ns <= now && answers) {
      shots.push_back({now, {.time_ns = *trigger_ns + stamp_error, .sequence = ++exposures}, next_content++});
      trigger_ns.reset();
    }
    if (shots.empty() || shots.front().arrives_ns > now) return StatusCode::not_ready;
    const Shot shot = shots.front();
    shots.pop_front();
    frame = shot.frame;
    EXPECT_TRUE(image.resize(64, 64).ok());
    std::memset(image.view().data, shot.content, image.view().area());
    if (shot.content != black) image.view().data[7] = 255;
    return {};
  }
  [[nodiscard]] bool triggered() const override { return is_triggered; }
  [[nodiscard]] bool restarts_counter() const override { return is_live; }
  [[nodiscard]] TimeNs granularity() const override { return grain; }
  [[nodiscard]] bool exposes_unasked() const override { return is_unasked || grain > 0; }
  Status trigger(TimeNs time) override {
    trigger_ns = time;
    return {};
  }

  std::deque<Shot> shots;
  bool is_triggered = false;
  bool is_live = false;
  bool is_unasked = false;
  TimeNs regular_ns = 2 * ns_per_s;  ///< the next exposure of its own
  bool answers = true;
  TimeNs stamp_error = 0;
  TimeNs grain = 0;
  std::optional<TimeNs> trigger_ns;
  std::int64_t exposures = 0;
  std::uint8_t next_content = 1;
};

class AcquisitionTest : public test::ComponentTest {
 protected:
  AcquisitionTest() { EXPECT_TRUE(acquisition->restore().ok()); }

  void shoot(double stamp_s, std::int64_t sequence, std::optional<double> arrival_s = {}) {
    camera.shots.push_back(
        {at_s(arrival_s.value_or(stamp_s)), {.time_ns = at_s(stamp_s), .sequence = sequence}, camera.next_content++});
  }
  std::int64_t command(double seconds) { return want(seconds, CaptureState::pending, CaptureSource::telecommand); }
  std::int64_t want(double seconds, CaptureState state = CaptureState::pending,
                    CaptureSource source = CaptureSource::regular) {
    CaptureRecord capture{
        .id = number_of<CaptureRecord>() + 1, .requested_ns = at_s(seconds), .source = source, .state = state};
    write(capture);
    return capture.id;
  }
  void step_at(double seconds) {
    clock.set(at_s(seconds));
    for (const Status& fault : run(*acquisition)) events.push_back(fault);
  }
  [[nodiscard]] std::size_t events_of(StatusCode code) const {
    std::size_t count = 0;
    for (const Status& event : events) count += event.is(code) ? 1 : 0;
    return count;
  }
  std::vector<TimeNs> frame_times() {
    std::vector<TimeNs> times;
    for (const FrameRecord& frame : test::records_of<FrameRecord>(store)) times.push_back(frame.time_ns);
    return times;
  }
  using Times = std::vector<TimeNs>;

  std::vector<Status> events;
  ScriptedCamera camera;
  std::unique_ptr<Acquisition> acquisition = std::make_unique<Acquisition>(store, camera, clock, mission);
};

TEST_F(AcquisitionTest, WithoutCapturesEveryFrameIsTaken) {
  for (int k = 1; k <= 4; ++k) shoot(k, k);
  step_at(10);
  EXPECT_EQ(frame_times(), (Times{at_s(1), at_s(2), at_s(3), at_s(4)}));
  EXPECT_EQ(events_of(StatusCode::frame_gap), 0U);
}

TEST_F(AcquisitionTest, ACaptureGetsTheNearestFrameOfAFreeCameraAndOnlyThat) {
  mission.capture_mode = CaptureMode::telecommanded;
  const std::int64_t capture = want(2.06);
  for (int k = 1; k <= 40; ++k) {
    shoot(0.1 * k, k);
    step_at(0.1 * k);
  }
  EXPECT_EQ(frame_times(), (Times{at_s(2.1)}));
  const auto record = read<CaptureRecord>(capture);
  EXPECT_EQ(record.state, CaptureState::exposed);
  EXPECT_EQ(record.frame_id, 1);
  EXPECT_EQ(record.exposed_ns, at_s(2.1));
  EXPECT_EQ(read<FrameRecord>(1).capture_id, capture);
  EXPECT_TRUE(events.empty());
}

TEST_F(AcquisitionTest, ATriggeredCameraExposesAtTheVeryTime) {
  mission.capture_mode = CaptureMode::telecommanded;
  camera.is_triggered = true;
  const std::int64_t capture = want(1.2345);
  for (int k = 0; k < 20; ++k) step_at(0.1 * k);
  EXPECT_EQ(frame_times(), (Times{at_s(1.2345)}));
  EXPECT_EQ(read<CaptureRecord>(capture).exposed_ns, at_s(1.2345));
}

TEST_F(AcquisitionTest, AFrameWithinTheCamerasGrainAnswersItsCaptureWithItsOwnTime) {
  mission.capture_mode = CaptureMode::telecommanded;
  camera.is_triggered = true;
  camera.grain = at_s(0.08);
  camera.stamp_error = at_s(0.06);
  const std::int64_t capture = want(1.2);
  for (int k = 0; k < 20; ++k) step_at(0.1 * k);
  EXPECT_EQ(frame_times(), (Times{at_s(1.2) + at_s(0.06)}));
  EXPECT_EQ(read<CaptureRecord>(capture).exposed_ns, at_s(1.2) + at_s(0.06));
  EXPECT_EQ(read<FrameRecord>(1).time_doubt, TimeDoubt::none);
  EXPECT_TRUE(events.empty());
}

TEST_F(AcquisitionTest, ACommandedImageFartherOffThanTheCamerasGrainIsNoSuccess) {
  mission.capture_mode = CaptureMode::telecommanded;
  const std::int64_t served = command(6.892), lost = command(10.1), behind = command(15);
  for (int k = 1; k <= 9; ++k) {
    if (k == 5) continue;  // the frame of 10 s is lost
    shoot(2 * k, k);
    step_at(2 * k);
  }
  EXPECT_EQ(read<CaptureRecord>(served).state, CaptureState::exposed);
  EXPECT_EQ(read<CaptureRecord>(served).exposed_ns, at_s(6));
  const auto record = read<CaptureRecord>(lost);
  EXPECT_EQ(record.state, CaptureState::no_frame);
  EXPECT_EQ(record.reason, static_cast<std::uint16_t>(StatusCode::capture_off_time));
  EXPECT_EQ(record.frame_id, 0);
  ASSERT_EQ(events_of(StatusCode::capture_off_time), 1U);
  for (const Status& event : events) {
    if (!event.is(StatusCode::capture_off_time)) continue;
    EXPECT_EQ(event.a, lost);
    EXPECT_EQ(event.b, 1'900'000) << "microseconds";
  }
  EXPECT_EQ(read<CaptureRecord>(behind).state, CaptureState::exposed);
}

TEST_F(AcquisitionTest, WhereEveryFrameIsTakenACommandedOneIsTakenAtItsTime) {
  camera.is_triggered = camera.is_unasked = true;
  const std::int64_t capture = command(4.9);
  const std::int64_t far = command(30);
  for (int k = 0; k <= 100; ++k) step_at(0.1 * k);
  EXPECT_EQ(read<CaptureRecord>(capture).state, CaptureState::exposed);
  EXPECT_EQ(read<CaptureRecord>(capture).exposed_ns, at_s(4.9));
  EXPECT_EQ(read<CaptureRecord>(far).state, CaptureState::pending);
  const Times times = frame_times();
  EXPECT_EQ(std::count(times.begin(), times.end(), at_s(4.9)), 1);
  EXPECT_EQ(std::count(times.begin(), times.end(), at_s(8)), 1) << "the others go on, with times of their own";
  EXPECT_EQ(events_of(StatusCode::frame_mis_stamped), 0U);
}

TEST_F(AcquisitionTest, WhereEveryFrameOfAFreeCameraIsTakenTheNearestAnswersTheCommand) {
  const std::int64_t capture = command(6.9);
  for (int k = 1; k <= 6; ++k) {
    shoot(2 * k, k);
    step_at(2 * k);
  }
  EXPECT_EQ(number_of<FrameRecord>(), 6);
  EXPECT_EQ(read<CaptureRecord>(capture).state, CaptureState::exposed);
  EXPECT_EQ(read<CaptureRecord>(capture).exposed_ns, at_s(6));
}

TEST_F(AcquisitionTest, BehindAnOutageOfACameraWithAGrainTheNextCaptureIsServed) {
  mission.capture_mode = CaptureMode::telecommanded;
  camera.is_triggered = true;
  camera.grain = at_s(0.08);
  camera.answers = false;
  const std::int64_t lost = want(1);
  const std::int64_t reachable = want(2.5);
  for (double t = 0.9; t < 2.3; t += 0.1) step_at(t);
  camera.answers = true;
  for (double t = 2.3; t < 3; t += 0.1) step_at(t);
  EXPECT_EQ(read<CaptureRecord>(reachable).state, CaptureState::exposed);
  for (double t = 3; t < 5; t += 0.1) step_at(t);
  EXPECT_EQ(read<CaptureRecord>(lost).state, CaptureState::no_frame);
}

TEST_F(AcquisitionTest, OfACameraWithAGrainEveryFrameCanBeTaken) {
  camera.is_triggered = true;
  camera.grain = at_s(0.08);
  step_at(1);
  EXPECT_EQ(camera.trigger_ns, Camera::any_time);
}

TEST_F(AcquisitionTest, ACaptureWithoutAFrameSaysSoOnce) {
  mission.capture_mode = CaptureMode::telecommanded;
  mission.capture_timeout_s = 3;
  camera.is_triggered = true;
  camera.answers = false;
  const std::int64_t lost = want(1);
  const std::int64_t next_one = want(6);
  step_at(3.9);
  EXPECT_EQ(read<CaptureRecord>(lost).state, CaptureState::pending);
  step_at(4.1);
  EXPECT_EQ(read<CaptureRecord>(lost).state, CaptureState::no_frame);
  ASSERT_EQ(events_of(StatusCode::capture_missed), 1U);
  EXPECT_EQ(events[0].a, lost);
  camera.answers = true;
  for (double t = 4.2; t < 8; t += 0.1) step_at(t);
  EXPECT_EQ(read<CaptureRecord>(next_one).state, CaptureState::exposed);
  EXPECT_EQ(events_of(StatusCode::capture_missed), 1U);
}

TEST_F(AcquisitionTest, ACaptureOfABurstThatTheCameraCannotAnswerIsNoFault) {
  mission.capture_mode = CaptureMode::telecommanded;
  camera.is_triggered = true;
  camera.answers = false;
  auto capture = read<CaptureRecord>(want(1));
  capture.source = CaptureSource::burst;
  write(capture);
  for (double t = 1; t < 6; t += 0.1) step_at(t);
  EXPECT_EQ(read<CaptureRecord>(capture.id).state, CaptureState::no_frame);
  EXPECT_EQ(events_of(StatusCode::capture_missed), 0U);
}

TEST_F(AcquisitionTest, CapturesFasterThanAFreeCameraGetAFrameOrANoFrameEach) {
  mission.capture_mode = CaptureMode::telecommanded;
  std::vector<std::int64_t> captures;
  for (int k = 0; k < 10; ++k) captures.push_back(want(2 + 0.1 * k));
  for (int k = 1; k <= 40; ++k) {
    shoot(0.25 * k, k);
    step_at(0.25 * k);
  }
  std::size_t exposed = 0, none = 0;
  std::vector<std::int64_t> frames;
  for (const std::int64_t id : captures) {
    const auto capture = read<CaptureRecord>(id);
    exposed += capture.state == CaptureState::exposed ? 1 : 0;
    none += capture.state == CaptureState::no_frame ? 1 : 0;
    if (capture.frame_id != 0) frames.push_back(capture.frame_id);
  }
  EXPECT_EQ(exposed + none, captures.size());
  EXPECT_GE(exposed, 4U);
  EXPECT_EQ(none, events_of(StatusCode::capture_missed));
  EXPECT_EQ(frames.size(), exposed);
  EXPECT_EQ(static_cast<std::int64_t>(exposed), number_of<FrameRecord>()) << "no frame answers two captures";
}

TEST_F(AcquisitionTest, ASupersededCaptureGetsNeitherFrameNorEvent) {
  mission.capture_mode = CaptureMode::telecommanded;
  camera.is_triggered = true;
  const std::int64_t id = want(2);
  step_at(1);
  auto capture = read<CaptureRecord>(id);
  capture.state = CaptureState::superseded;
  write(capture);
  for (double t = 1.1; t < 9; t += 0.1) step_at(t);
  EXPECT_EQ(number_of<FrameRecord>(), 0);
  EXPECT_TRUE(events.empty());
}

TEST_F(AcquisitionTest, LostFramesAreCounted) {
  shoot(1, 1);
  shoot(2, 2);
  shoot(6, 6);
  step_at(10);
  ASSERT_EQ(events_of(StatusCode::frame_gap), 1U);
  EXPECT_EQ(events[events.size() - 1].b, 3);
}

TEST_F(AcquisitionTest, ARepeatedFrameIsLeftOutWhetherItsCounterOrOnlyItsImageRepeats) {
  shoot(1, 1);
  shoot(2, 2);
  shoot(2, 2);
  shoot(3, 3);
  camera.shots.push_back({at_s(4), {.time_ns = at_s(4), .sequence = 4}, camera.shots.back().content});
  step_at(10);
  EXPECT_EQ(frame_times(), (Times{at_s(1), at_s(2), at_s(3)}));
  EXPECT_EQ(events_of(StatusCode::frame_duplicated), 2U);
}

TEST_F(AcquisitionTest, BlackFramesAreNoRepetitions) {
  for (int k = 1; k <= 3; ++k) camera.shots.push_back({at_s(k), {.time_ns = at_s(k), .sequence = k}, black});
  step_at(5);
  EXPECT_EQ(number_of<FrameRecord>(), 3);
  EXPECT_EQ(events_of(StatusCode::frame_duplicated), 0U);
}

TEST_F(AcquisitionTest, ALateFrameStillAnswersItsCapture) {
  mission.capture_mode = CaptureMode::telecommanded;
  const std::int64_t capture = want(2);
  for (int k = 1; k <= 5; ++k) shoot(0.5 * k, k, 0.5 * k + (k == 4 ? 1.2 : 0));
  for (double t = 0; t < 5; t += 0.1) step_at(t);
  const auto record = read<CaptureRecord>(capture);
  EXPECT_EQ(record.state, CaptureState::exposed);
  EXPECT_EQ(record.exposed_ns, at_s(2));
  EXPECT_GE(events_of(StatusCode::frame_late), 1U);
}

TEST_F(AcquisitionTest, AWrongStampOfASteadyCameraIsReplacedByItsPeriodAndMarked) {
  for (int k = 1; k <= 12; ++k) {
    const double stamp = k == 8 ? 7.1 : k == 10 ? 3 : k;  // one a bit early, one that jumps far back
    shoot(stamp, k, k);
    step_at(k);
  }
  Times all;
  for (int k = 1; k <= 12; ++k) all.push_back(at_s(k));
  EXPECT_EQ(frame_times(), all);
  EXPECT_EQ(events_of(StatusCode::frame_mis_stamped), 2U);
  EXPECT_EQ(read<FrameRecord>(8).time_doubt, TimeDoubt::off_period);
  EXPECT_EQ(read<FrameRecord>(9).time_doubt, TimeDoubt::none) << "its neighbour is not blamed";
  EXPECT_EQ(read<FrameRecord>(10).time_doubt, TimeDoubt::off_period);
}

TEST_F(AcquisitionTest, ACounterThatLeapsBeyondAllTimeTellsNothingOfTheTime) {
  for (int k = 1; k <= 10; ++k) {
    shoot(k, k < 9 ? k : 20'000'000'000 + k);
    step_at(k);
  }
  Times all;
  for (int k = 1; k <= 10; ++k) all.push_back(at_s(k));
  EXPECT_EQ(frame_times(), all);
  EXPECT_EQ(events_of(StatusCode::frame_mis_stamped), 0U);
}

TEST_F(AcquisitionTest, BeforeAPeriodIsKnownABackwardJumpIsLeftOut) {
  shoot(5, 1, 5);
  shoot(3, 2, 6);
  shoot(7, 3, 7);
  step_at(10);
  EXPECT_EQ(frame_times(), (Times{at_s(5), at_s(7)}));
  EXPECT_EQ(events_of(StatusCode::time_not_monotonic), 1U);
}

TEST_F(AcquisitionTest, AClockThatJumpsForGoodIsFollowedInTheEnd) {
  for (int k = 1; k <= 40; ++k) {
    shoot(k < 10 ? k : k - 5.4, k, k);
    step_at(k);
  }
  const auto last_frame = read<FrameRecord>(number_of<FrameRecord>());
  // The period carries it for some frames; then frames stamped before the last one are left out until time catches up.
  EXPECT_GE(number_of<FrameRecord>(), 34);
  EXPECT_EQ(last_frame.sequence, 40);
}

TEST_F(AcquisitionTest, BeforeAPeriodIsKnownAStampAheadOfTheClockIsLeftOutAndLaterFramesAreNot) {
  shoot(1, 1, 1);
  shoot(9, 2, 2);
  shoot(3, 3, 3);
  for (int k = 1; k <= 3; ++k) step_at(k);
  EXPECT_EQ(frame_times(), (Times{at_s(1), at_s(3)}));
  EXPECT_EQ(events_of(StatusCode::time_ahead), 1U);
}

TEST_F(AcquisitionTest, AFrameOutOfOrderIsLeftOut) {
  shoot(1, 1);
  shoot(3, 3);
  shoot(2, 2);
  shoot(4, 4);
  step_at(5);
  EXPECT_EQ(frame_times(), (Times{at_s(1), at_s(3), at_s(4)}));
  EXPECT_EQ(events_of(StatusCode::frame_out_of_order), 1U);
}

TEST_F(AcquisitionTest, ASilentCameraIsReportedOnce) {
  for (int k = 1; k <= 8; ++k) {
    shoot(k, k);
    step_at(k);
  }
  for (double t = 8; t < 60; t += 0.5) step_at(t);
  EXPECT_EQ(events_of(StatusCode::camera_silent), 1U);
  shoot(60, 9);
  for (double t = 60; t < 90; t += 0.5) step_at(t);
  EXPECT_EQ(events_of(StatusCode::camera_silent), 2U);
}

TEST_F(AcquisitionTest, AWrongStampOfATriggeredCameraIsReplacedByTheCommandedTime) {
  mission.capture_mode = CaptureMode::telecommanded;
  camera.is_triggered = true;
  camera.stamp_error = -at_s(0.4);
  const std::int64_t capture = want(2);
  for (double t = 0; t < 4; t += 0.1) step_at(t);
  EXPECT_EQ(frame_times(), (Times{at_s(2)}));
  EXPECT_EQ(read<CaptureRecord>(capture).state, CaptureState::exposed);
  EXPECT_EQ(read<FrameRecord>(1).time_doubt, TimeDoubt::off_command);
}

TEST_F(AcquisitionTest, AfterARestartALiveCameraCountsAnewAndNoFrameOfItIsLost) {
  camera.is_live = true;
  const auto shoot_at = [&](int time, int sequence) {
    shoot(time, sequence);
    step_at(time);
  };
  for (int k = 1; k <= 20; ++k) shoot_at(k, k);
  ASSERT_TRUE(acquisition->restore().ok());
  for (int k = 1; k <= 3; ++k) shoot_at(40 + k, k);
  const Times times = frame_times();
  ASSERT_EQ(times.size(), 23U);
  EXPECT_EQ(times[20], at_s(41)) << "the pause belongs to no period";
  EXPECT_TRUE(events.empty());
}

TEST_F(AcquisitionTest, AfterARestartWhatIsStoredIsPassedOverInSilence) {
  for (int k = 1; k <= 3; ++k) {
    shoot(k, k);
    step_at(k);
  }
  acquisition = std::make_unique<Acquisition>(store, camera, clock, mission);
  ASSERT_TRUE(acquisition->restore().ok());
  camera.next_content = 1;
  for (int k = 1; k <= 5; ++k) shoot(k, k);
  for (int k = 3; k <= 5; ++k) step_at(k);
  EXPECT_EQ(frame_times(), (Times{at_s(1), at_s(2), at_s(3), at_s(4), at_s(5)}));
  EXPECT_TRUE(events.empty());
}

TEST_F(AcquisitionTest, AFrameThatCannotBeStoredNowIsHeldUntilItCan) {
  mission.capture_interval_s = 0;
  test::FailingStore failing(store);
  std::int64_t commits = 0;
  failing.judge_by([&](const test::FailingStore::Call& call) {
    if (call.kind != test::StoreCall::commit) return Status{};
    return ++commits % 3 != 0 ? Status{StatusCode::store_error, 10} : Status{};
  });
  acquisition = std::make_unique<Acquisition>(failing, camera, clock, mission);
  ASSERT_TRUE(acquisition->restore().ok());
  for (int i = 1; i <= 5; ++i) shoot(2 * i, i);
  for (int i = 1; i <= 40; ++i) step_at(2 + 0.5 * i);
  ASSERT_EQ(number_of<FrameRecord>(), 5);
  for (std::int64_t id = 1; id <= 5; ++id)
    EXPECT_EQ(read<FrameRecord>(id).time_ns, at_s(2.0 * static_cast<double>(id)));
  EXPECT_EQ(events_of(StatusCode::frame_gap), 0U);
}

TEST_F(AcquisitionTest, NoFrameGetsTheNumberOfOneThatIsOnRecord) {
  mission.capture_interval_s = 0;
  for (int i = 1; i <= 3; ++i) shoot(2 * i, i);
  step_at(7);
  ASSERT_EQ(number_of<FrameRecord>(), 3);
  for (const bool newer_only : {true, false}) {
    damage_checkpoints(newer_only);
    const std::int64_t before = number_of<FrameRecord>();
    const auto newest = read<FrameRecord>(before);
    acquisition = std::make_unique<Acquisition>(store, camera, clock, mission);
    EXPECT_EQ(acquisition->restore().code, newer_only ? StatusCode::checkpoint_older : StatusCode::checkpoint_lost);
    const double now = newer_only ? 10 : 14;
    shoot(now, static_cast<std::int64_t>(now / 2));
    shoot(now + 2, static_cast<std::int64_t>(now / 2) + 1);
    step_at(now + 3);
    EXPECT_EQ(number_of<FrameRecord>(), before + 2);
    EXPECT_EQ(read<FrameRecord>(before).time_ns, newest.time_ns);
  }
}

TEST_F(AcquisitionTest, WhileTheStoreIsLockedOneImageIsHeldAndTheOthersAreCounted) {
  mission.capture_mode = CaptureMode::regular;
  mission.capture_interval_s = 2;
  camera.is_triggered = true;
  test::FailingStore failing(store);
  acquisition = std::make_unique<Acquisition>(failing, camera, clock, mission);
  ASSERT_TRUE(acquisition->restore().ok());
  const std::int64_t capture = want(2);
  step_at(1);
  failing.lock();
  for (int k = 20; k <= 120; ++k) {
    clock.set(at_s(0.1 * k));
    EXPECT_EQ(acquisition->step().status.code, StatusCode::store_locked) << k;
  }
  failing.recover();
  for (int k = 121; k <= 125; ++k) step_at(0.1 * k);
  EXPECT_EQ(frame_times(), (Times{at_s(2)})) << "the image in hand";
  EXPECT_EQ(read<CaptureRecord>(capture).state, CaptureState::exposed);
  ASSERT_EQ(events_of(StatusCode::images_lost), 1U);
  for (const Status& event : events) {
    if (!event.is(StatusCode::images_lost)) continue;
    EXPECT_EQ(event.a, 5) << "those of 4, 6, 8, 10 and 12 s";
    EXPECT_EQ(event.b, 10'100);
  }
}

TEST_F(AcquisitionTest, FramesOfAFreeCameraThatTheLockHasCostAreCountedWithThisCause) {
  mission.capture_interval_s = 0;
  test::FailingStore failing(store);
  acquisition = std::make_unique<Acquisition>(failing, camera, clock, mission);
  ASSERT_TRUE(acquisition->restore().ok());
  shoot(2, 1);
  step_at(2);
  failing.lock();
  shoot(4, 2);
  for (int k = 40; k < 100; ++k) {
    clock.set(at_s(0.1 * k));
    EXPECT_EQ(acquisition->step().status.code, StatusCode::store_locked) << k;
  }
  failing.recover();
  shoot(12, 6);
  shoot(14, 8);
  for (const double now : {10.0, 12.0, 14.0}) step_at(now);
  EXPECT_EQ(frame_times(), (Times{at_s(2), at_s(4), at_s(12), at_s(14)}));
  ASSERT_EQ(events_of(StatusCode::images_lost), 1U);
  ASSERT_EQ(events_of(StatusCode::frame_gap), 1U) << "the later gap has another cause";
  for (const Status& event : events) {
    if (event.is(StatusCode::images_lost)) {
      EXPECT_EQ(event.a, 3);
    }
    if (event.is(StatusCode::frame_gap)) {
      EXPECT_EQ(event.b, 1);
    }
  }
}

TEST_F(AcquisitionTest, AFrameThatNobodyWantsTakesNoPlaceWhileTheStoreIsLocked) {
  mission.capture_mode = CaptureMode::telecommanded;
  test::FailingStore failing(store);
  acquisition = std::make_unique<Acquisition>(failing, camera, clock, mission);
  ASSERT_TRUE(acquisition->restore().ok());
  const std::int64_t capture = command(6);
  for (int k = 1; k <= 4; ++k) {
    shoot(k, k);
    step_at(k);
  }
  failing.lock();
  for (int k = 5; k <= 9; ++k) {
    shoot(k, k);
    clock.set(at_s(k));
    EXPECT_EQ(acquisition->step().status.code, StatusCode::store_locked) << k;
  }
  failing.recover();
  for (int k = 10; k <= 14; ++k) step_at(k);
  EXPECT_EQ(frame_times(), (Times{at_s(6)}));
  EXPECT_EQ(read<CaptureRecord>(capture).state, CaptureState::exposed);
  EXPECT_EQ(events_of(StatusCode::frame_gap), 0U) << "none was lost";
  EXPECT_EQ(events_of(StatusCode::camera_silent), 0U);
}

}  // namespace
}  // namespace ilp
