// The simulated camera as time passes: at the commanded times exactly, else at the scenario's own.
#include <gtest/gtest.h>
#include <unistd.h>

#include <memory>
#include <vector>

#include "sim/sil/world_camera.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp::sil {
namespace {

world::Scenario small_scenario() {
  world::Scenario scenario = world::load_scenario("mars-plains", {});
  CameraModel& camera = scenario.flight.camera;
  camera.width = 96;
  camera.height = 72;
  camera.fx = camera.fy = 80;
  camera.cx = 47.5;
  camera.cy = 35.5;
  scenario.flight.frames = 10;
  return scenario;
}

class WorldCameraTest : public testing::Test {
 protected:
  /// In real time a rendering takes what it takes: waits for it, with a bound.
  TimeNs frame_at(TimeNs trigger, TimeNs now) {
    CameraFrame frame;
    Status status = StatusCode::not_ready;
    for (int i = 0; i < 10'000 && status.is(StatusCode::not_ready); ++i) {
      EXPECT_TRUE(camera_->trigger(trigger).ok());
      status = camera_->capture(now, *image_, frame);
      if (status.is(StatusCode::not_ready)) ::usleep(2000);
    }
    EXPECT_TRUE(status.ok()) << static_cast<int>(status.code);
    return status.ok() ? frame.time_ns : -1;
  }
  const test::TemporaryFolder folder_;
  std::unique_ptr<WorldCamera> camera_ = std::make_unique<WorldCamera>(
      small_scenario(), folder_ / "flight", WorldCamera::Options{.resume = false, .as_time_passes = true});
  std::unique_ptr<FrameImage> image_ = std::make_unique<FrameImage>();
};

TEST_F(WorldCameraTest, UnaskedItExposesAtTheScenariosTimesAndLeavesOutWhatItComesTooLateFor) {
  EXPECT_TRUE(camera_->exposes_unasked());
  EXPECT_EQ(frame_at(Camera::any_time, 0), 0);
  EXPECT_EQ(frame_at(Camera::any_time, 2 * ns_per_s), 2 * ns_per_s);
  CameraFrame frame;
  // Nobody asks for 9 s.
  EXPECT_TRUE(camera_->capture(11 * ns_per_s, *image_, frame).is(StatusCode::not_ready));
  EXPECT_TRUE(camera_->trigger(Camera::any_time).ok());
  EXPECT_TRUE(camera_->capture(11 * ns_per_s, *image_, frame).is(StatusCode::not_ready)) << "12 s is to come";
  EXPECT_EQ(frame_at(Camera::any_time, 12 * ns_per_s), 12 * ns_per_s);
}

TEST_F(WorldCameraTest, ACommandedImageIsOfItsTimeHoweverLateItIsRendered) {
  EXPECT_EQ(frame_at(Camera::any_time, 0), 0);
  // The next one of its own is being rendered when the command comes.
  EXPECT_TRUE(camera_->trigger(Camera::any_time).ok());
  EXPECT_EQ(frame_at(892 * ns_per_ms, 5 * ns_per_s), 892 * ns_per_ms);
  EXPECT_EQ(frame_at(5592 * ns_per_ms, 6 * ns_per_s), 5592 * ns_per_ms);
  EXPECT_EQ(frame_at(Camera::any_time, 8 * ns_per_s), 6 * ns_per_s);
  camera_->finish(1);
}

TEST_F(WorldCameraTest, ItEndsWithTheFlight) {
  CameraFrame frame;
  EXPECT_TRUE(camera_->capture(1000 * ns_per_s, *image_, frame).is(StatusCode::end_of_stream));
}

}  // namespace
}  // namespace ilp::sil
