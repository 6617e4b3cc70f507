// The motion of a keyframe's image from the frames about it, against swings that are given by formula.
#include "fsw/motion/keyframe_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "fsw/base/math.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/geometry/rolling_shutter.hpp"
#include "fsw/vision/overlap/overlap.hpp"
#include "tests/unit/shared/component_fixture.hpp"

namespace ilp {
namespace {

constexpr double interval_s = 0.5, period_s = 4;

class KeyframeMotion : public test::ComponentTest {
 protected:
  KeyframeMotion() {
    camera_.width = 640;
    camera_.height = 480;
    camera_.fx = camera_.fy = 550;
    camera_.cx = 320;
    camera_.cy = 240;
    camera_.readout_s = 0.03;
    strip_.id = strip_.first_keyframe_id = 1;
    strip_.last_keyframe_id = 2;
    write(strip_);
  }

  /// From the image at time 0 to that of a camera that turns about its x axis.
  [[nodiscard]] Mat3 plane_at(double angle) const {
    Mat3 k = Mat3::Identity();
    k(0, 0) = k(1, 1) = camera_.fx;
    k(0, 2) = camera_.cx;
    k(1, 2) = camera_.cy;
    const Mat3 h = k * rotation_from_vector(Vec3(angle, 0, 0)) * k.inverse();
    return h / h(2, 2);
  }
  /// Frames 1 to `frames`; keyframe 1 is frame 1 and keyframe 2 is frame 3.
  void fly(std::int64_t frames, const std::function<double(double)>& angle) {
    for (std::int64_t id = 1; id <= frames; ++id) {
      FrameRecord frame{.id = id, .time_ns = (id - 3) * 500 * ns_per_ms};
      write(frame);
      OverlapRecord overlap{.id = id};
      write(overlap);
      const std::int64_t with = id <= 3 ? 1 : 3;
      FramePlaneRecord plane{.id = id, .keyframe_id = id <= 3 ? 1 : 2};
      const auto at = [&](std::int64_t i) { return angle(interval_s * static_cast<double>(i - 3)); };
      const Mat3 h = plane_at(at(id) - at(with));
      for (int i = 0; i < 9; ++i) plane.plane_from_keyframe[i] = h(i / 3, i % 3);
      if (id != 1) write(plane);
      if (id != 1 && id != 3) continue;
      KeyframeRecord keyframe{.id = id == 1 ? 1 : 2, .frame_id = id, .strip_id = 1};
      keyframe.index = static_cast<std::int32_t>(keyframe.id - 1);
      keyframe.time_ns = frame.time_ns;
      if (id == 3) std::copy_n(plane.plane_from_keyframe, 9, keyframe.plane_from_previous);
      write(keyframe);
    }
  }
  ShutterRecord motion(std::int64_t keyframe = 2) {
    ShutterRecord shutter;
    const Result<bool> ready = keyframe_motion(store, camera_record(camera_), read<KeyframeRecord>(keyframe), shutter);
    EXPECT_TRUE(ready.ok() && ready.value());
    return shutter;
  }
  CameraModel camera_;
  StripRecord strip_;
};

double swing(double seconds) {
  return 0.08 * std::sin(2 * pi / period_s * seconds);
}
constexpr double fastest = 0.08 * 2 * pi / period_s;

// A turn w about x moves the image's middle by -w, and points beside it by more: m5 = -w, m7 = -(-w).
TEST_F(KeyframeMotion, IsTheTurnLessTheAttenuationOfFiveFrames) {
  fly(5, swing);
  const ShutterRecord shutter = motion();
  EXPECT_EQ(shutter.id, 2);
  EXPECT_EQ(shutter.source, MotionSource::frames);
  EXPECT_EQ(shutter.frames, 4U);
  const double x = 2 * pi * interval_s / period_s;
  const double attenuation = (8 * std::sin(x) - std::sin(2 * x)) / (6 * x);
  EXPECT_NEAR(shutter.motion[5], -fastest * attenuation, 0.005 * fastest);
  EXPECT_NEAR(shutter.motion[7], fastest * attenuation, 0.03 * fastest);
  for (const int i : {1, 2, 3, 6}) EXPECT_NEAR(shutter.motion[i], 0, 1e-3) << i;
  EXPECT_GT(shutter.sigma_px_s, 0.01 * fastest * camera_.fx);
  EXPECT_LT(shutter.sigma_px_s, 0.1 * fastest * camera_.fx);
}

TEST_F(KeyframeMotion, WaitsForTheNextTwoFramesOrTheEndOfTheStrip) {
  fly(4, swing);
  ShutterRecord shutter;
  EXPECT_FALSE(keyframe_motion(store, camera_record(camera_), read<KeyframeRecord>(2), shutter).value());
  strip_.end = StripEnd::end_of_flight;
  write(strip_);
  EXPECT_EQ(motion().frames, 3U);
  EXPECT_NEAR(motion().motion[5], -fastest, 0.06 * fastest);
  EXPECT_GE(motion().sigma_px_s, std::fabs(motion().motion[5] + fastest) * camera_.fx) << "three frames check nothing";
}

TEST_F(KeyframeMotion, HasASourceOnlyWithFramesNearby) {
  fly(3, swing);
  strip_.end = StripEnd::end_of_flight;
  write(strip_);
  EXPECT_EQ(motion().frames, 2U);
  camera_.readout_s = 0;
  EXPECT_EQ(motion().id, 0) << "no record for a camera whose rows are exposed at once";
  CameraRecord open = camera_record(camera_);
  open.sigma_readout_s = 0.02;
  ShutterRecord shutter;
  ASSERT_TRUE(keyframe_motion(store, open, read<KeyframeRecord>(2), shutter).value());
  EXPECT_EQ(shutter.frames, 2U) << "a readout time is found by the motion";
  const double between_rows = std::hypot(shutter.motion[2], shutter.motion[5]) * open.sigma_readout_s;
  double squares = 0;
  for (int row = -50; row <= 50; ++row) squares += std::pow(between_rows * row / 100, 2) / 101;
  EXPECT_NEAR(shutter_error_rad(open, shutter), std::sqrt(squares), 0.02 * between_rows);
}

TEST_F(KeyframeMotion, IsUnknownForAKeyframeWithoutOthers) {
  fly(1, swing);
  strip_.end = StripEnd::end_of_flight;
  write(strip_);
  const ShutterRecord alone = motion(1);
  EXPECT_EQ(alone.id, 1);
  EXPECT_EQ(alone.source, MotionSource::none);
  EXPECT_TRUE(std::isnan(alone.sigma_px_s));
}

TEST_F(KeyframeMotion, PassesOverFramesThatAreFarAwayInTime) {
  fly(5, swing);
  FrameRecord late = read<FrameRecord>(5);
  late.time_ns = 60 * ns_per_s;
  write(late);
  EXPECT_EQ(motion().frames, 3U);
}

}  // namespace
}  // namespace ilp
