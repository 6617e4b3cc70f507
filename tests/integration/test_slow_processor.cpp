// The flight software on a processor that is too slow for its camera: less work, on time, and back again. Time is that
// of a clock which charges every step of a component its price, so that the flight is the same on every machine.
#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <vector>

#include "bsp/flight/flight_software.hpp"
#include "fsw/executive/frame_timing.hpp"
#include "hal/camera/directory/directory_camera.hpp"
#include "hal/camera/directory/pgm.hpp"
#include "hal/link/outbox/outbox_link.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "sim/host/colmap.hpp"
#include "tests/integration/flight_files.hpp"
#include "tests/support/flight_kit.hpp"
#include "tests/support/store_records.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

const fs::path plain = test::prepared_flights() / "plain";
constexpr int images = 20;
constexpr TimeNs interval_ns = 4 * ns_per_s;

/// Prices are charged when the clock is read after the step.
class PricedClock final : public Clock {
 public:
  TimeNs now() override {
    charge();
    return now_;
  }
  void sleep_until(TimeNs time) override { now_ = std::max(now(), time); }
  TimeNs processor_time() override { return now(); }

  const Executive* executive = nullptr;
  TimeNs slow_until = 0;

 private:
  static TimeNs price_of(ComponentId component) {
    switch (component) {
      case ComponentId::overlap_checker:
        return 60 * ns_per_ms;
      case ComponentId::camera_calibrator:
      case ComponentId::structure_and_motion:
        return 50 * ns_per_ms;
      case ComponentId::dense_matcher:
      case ComponentId::richness_scorer:
        return 90 * ns_per_ms;
      case ComponentId::compressor:
        return 250 * ns_per_ms;
      default:
        return 100 * ns_per_us;
    }
  }
  void charge() {
    if (executive == nullptr) return;
    for (std::size_t i = 0; i < stage_count; ++i) {
      const ComponentId component = schedule[i].component;
      const std::uint32_t steps = executive->stats(component).steps;
      const TimeNs price = price_of(component) / (now_ < slow_until ? 1 : 10);
      now_ += static_cast<TimeNs>(steps - charged_[i]) * price;
      charged_[i] = steps;
    }
  }

  TimeNs now_ = 0;
  std::array<std::uint32_t, stage_count> charged_{};
};

class SlowProcessorTest : public testing::Test {
 protected:
  SlowProcessorTest() {
    fs::create_directories(folder / "outbox");
    fs::create_directories(folder / "acknowledged");
    mission.load_window_s = 4;
    mission.overload_keyframes = 1;
    mission.recovery_windows = 3;
    mission.window_keyframes = 3;
  }

  void fly(TimeNs slow_until, TimeNs end) {
    PricedClock clock;
    clock.slow_until = slow_until;
    DirectoryCamera camera;
    const CameraModel model = host::read_colmap_camera(plain / "cameras.txt");
    ASSERT_TRUE(camera.open((plain / "index.txt").c_str(), model.width, model.height, read_pgm).ok());
    OutboxLink link;
    ASSERT_TRUE(link.open((folder / "outbox").c_str(), (folder / "acknowledged").c_str()).ok());
    test::FlightKit software({.store = store, .camera = camera, .link = link, .clock = clock, .real_time = true},
                             mission);
    ASSERT_TRUE(software.start(model).ok());
    clock.executive = &software->executive();
    for (TimeNs next = 0; next < end; next = next_frame_begin(next, clock.now())) {
      clock.sleep_until(next);
      software->executive().run_minor_frame(next);
      most_degraded = std::max(most_degraded, software->executive().timing().degraded);
    }
    timing = software->executive().timing();
  }
  template <typename Record>
  std::vector<Record> all() {
    return test::records_of<Record>(store);
  }
  /// All were taken, each at its time.
  void expect_every_image() {
    const std::vector<FrameRecord> frames = all<FrameRecord>();
    ASSERT_EQ(frames.size(), static_cast<std::size_t>(images));
    for (int i = 0; i < images; ++i) EXPECT_EQ(frames[static_cast<std::size_t>(i)].time_ns, i * interval_ns);
  }

  const test::TemporaryFolder folder;
  std::vector<std::byte> region = std::vector<std::byte>(std::size_t{64} << 20U);
  RamStore store{region};
  MissionParameters mission;
  TimingRecord timing;
  std::uint8_t most_degraded = 0;
};

TEST_F(SlowProcessorTest, WorkIsReducedTheImagesComeAtTheirTimesAndWorkIsRestored) {
  fly(60 * ns_per_s, 140 * ns_per_s);
  expect_every_image();
  EXPECT_EQ(most_degraded, 2);
  EXPECT_EQ(timing.degraded, 0) << "the processor has had rest since";
  // Coding a product is the longest step: nothing else may make a frame late.
  EXPECT_LE(timing.latest_ns, minor_frame_ns);
  EXPECT_LE(timing.longest_ns, 250 * ns_per_ms + minor_frame_ns);

  std::array<int, 3> keyframes{}, with_depth{};
  for (const KeyframeRecord& keyframe : all<KeyframeRecord>()) {
    ++keyframes.at(keyframe.degraded);
    DepthRecord depth;
    ASSERT_TRUE(get(store, keyframe.id, depth).ok());
    with_depth.at(keyframe.degraded) += depth.verdict == DepthVerdict::ok ? 1 : 0;
  }
  EXPECT_GT(keyframes[0], 0);
  EXPECT_GT(keyframes[2], 0);
  EXPECT_GT(with_depth[2], 0);
  std::size_t reduced = 0, restored = 0;
  for (const EventRecord& event : all<EventRecord>()) {
    reduced += event.code == static_cast<std::uint16_t>(StatusCode::work_reduced) ? 1 : 0;
    restored += event.code == static_cast<std::uint16_t>(StatusCode::work_restored) ? 1 : 0;
    EXPECT_NE(event.code, static_cast<std::uint16_t>(StatusCode::frame_gap));
    EXPECT_NE(event.code, static_cast<std::uint16_t>(StatusCode::frame_late));
  }
  EXPECT_GE(reduced, 2U);
  EXPECT_EQ(reduced, restored);
}

TEST_F(SlowProcessorTest, AProcessorThatKeepsUpLeavesEverythingAsItIs) {
  fly(0, 100 * ns_per_s);
  expect_every_image();
  EXPECT_EQ(most_degraded, 0);
  EXPECT_EQ(timing.degraded_changes, 0U);
  for (const KeyframeRecord& keyframe : all<KeyframeRecord>()) EXPECT_EQ(keyframe.degraded, 0);
}

}  // namespace
}  // namespace ilp
