// A simulated camera whose exposure is set: light, saturation, noise, blur, and how it obeys.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "fsw/imaging/exposure_control.hpp"
#include "sim/sil/world_camera.hpp"
#include "sim/world/sensor.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp::sil {
namespace {

constexpr TimeNs interval = 2 * ns_per_s;

class ExposedWorld : public testing::Test {
 protected:
  ExposedWorld() {
    scenario_ = world::load_scenario("mars-plains", {});
    CameraModel& camera = scenario_.flight.camera;
    camera.width = 96;
    camera.height = 72;
    camera.fx = camera.fy = 80;
    camera.cx = 47.5;
    camera.cy = 35.5;
    scenario_.flight.frames = 60;
    scenario_.effects = {};
    scenario_.effects.settable_us = 2000;
  }
  void begin() {
    camera_ = std::make_unique<WorldCamera>(scenario_, folder_ / "flight", WorldCamera::Options{.unasked = true});
  }
  /// The next image at the scenario's own times.
  void take() {
    for (; now_ < 60 * interval; now_ += 100 * ns_per_ms) {
      ASSERT_TRUE(camera_->trigger(Camera::any_time).ok());
      const Status status = camera_->capture(now_, *image_, frame_);
      if (!status.is(StatusCode::not_ready)) {
        ASSERT_TRUE(status.ok());
        return;
      }
    }
    FAIL() << "the flight is over";
  }
  [[nodiscard]] double mean() const {
    double sum = 0;
    const auto view = image_->view();
    for (std::int32_t y = 0; y < view.height; ++y) {
      for (std::int32_t x = 0; x < view.width; ++x) sum += view.row(y)[x];
    }
    return sum / (view.width * view.height);
  }
  void set(std::int64_t exposure_us, std::int64_t gain_milli) {
    ExposureSetting setting{exposure_us, gain_milli};
    ASSERT_TRUE(camera_->set_exposure(setting).ok());
  }

  world::Scenario scenario_;
  const test::TemporaryFolder folder_;
  std::unique_ptr<WorldCamera> camera_;
  std::unique_ptr<FrameImage> image_ = std::make_unique<FrameImage>();
  CameraFrame frame_;
  TimeNs now_ = 0;
};

TEST_F(ExposedWorld, GreyIsProportionalToExposureAndGainAndEndsAtWhite) {
  begin();
  take();
  const double usual = mean();
  EXPECT_EQ(frame_.exposure, (ExposureSetting{2000, 1000}));
  EXPECT_GT(usual, 90);
  EXPECT_LT(usual, 165);
  set(500, 1000);
  take();
  EXPECT_NEAR(mean(), usual / 4, 4);
  EXPECT_EQ(frame_.exposure, (ExposureSetting{500, 1000}));
  set(500, 4000);
  take();
  EXPECT_NEAR(mean(), usual, 12);
  set(100'000, 1000);
  take();
  EXPECT_EQ(mean(), 255);
}

TEST_F(ExposedWorld, GainRaisesTheNoiseOfTheSameGrey) {
  scenario_.effects.shot_noise = true;
  scenario_.effects.full_well_e = 4000;
  scenario_.effects.read_noise_grey = 1;
  const host::Raster<float> even(200, 200, 1.0F);
  const auto spread = [&](double exposure_us, double gain) {
    host::Raster<std::uint8_t> grey(200, 200);
    world::expose(world::exposed_with(scenario_.effects, exposure_us, gain, 1), 5, 1, even, grey);
    double sum = 0, squares = 0;
    for (const std::uint8_t value : grey.samples) {
      sum += value;
      squares += static_cast<double>(value) * value;
    }
    const double count = 200.0 * 200, average = sum / count;
    EXPECT_NEAR(average, 127.5, 0.5);
    return std::sqrt(squares / count - average * average);
  };
  // Shot noise: variance grey * 255 / full well, times the gain; read noise: times its square.
  for (const double gain : {1.0, 4.0, 8.0}) {
    const double expected = std::sqrt(127.5 * 255 / 4000 * gain + gain * gain + 1.0 / 12);
    EXPECT_NEAR(spread(2000 / gain, gain), expected, 0.03 * expected) << gain;
  }
}

TEST_F(ExposedWorld, ACameraThatObeysLateSaysWhatItTookEachImageWith) {
  scenario_.effects.obeys_after = 2;
  begin();
  take();
  set(500, 1000);
  take();
  EXPECT_EQ(frame_.exposure.exposure_us, 2000);
  take();
  EXPECT_EQ(frame_.exposure.exposure_us, 2000);
  take();
  EXPECT_EQ(frame_.exposure.exposure_us, 500);
}

TEST_F(ExposedWorld, TheLightChangesInItsWindow) {
  scenario_.effects.light_from_s = 3;
  scenario_.effects.light_for_s = 2;
  scenario_.effects.light_share = 0.25;
  begin();
  take();
  const double usual = mean();
  take();  // 2 s
  EXPECT_NEAR(mean(), usual, 12);
  take();  // 4 s
  EXPECT_NEAR(mean(), usual / 4, 5);
  take();  // 6 s
  EXPECT_NEAR(mean(), usual, 12);
}

TEST_F(ExposedWorld, ACameraWithAFixedExposureSaysSo) {
  scenario_.effects.settable_us = 0;
  begin();
  ExposureRange range;
  EXPECT_TRUE(camera_->exposure_range(range).is(StatusCode::camera_control_missing));
  take();
  EXPECT_FALSE(frame_.exposure.known());
}

TEST_F(ExposedWorld, FromADarkStartTheControlFindsTheLightOfRenderedGround) {
  scenario_.effects = world::realistic_effects();
  scenario_.effects.gain_step = 0;
  scenario_.effects.settable_us = 2000;
  scenario_.effects.first_us = 20;
  begin();
  ExposureControl control;
  ExposureRange range;
  ASSERT_TRUE(camera_->exposure_range(range).ok());
  control.begin(range);
  ImageBrightness seen;
  for (int i = 0; i < 12; ++i) {
    take();
    seen = measure_brightness(image_->view());
    if (i == 0) {
      EXPECT_EQ(frame_.exposure, (ExposureSetting{20, 1000}));
      EXPECT_LT(seen.bright, 10);
    }
    ExposureSetting next;
    Status event;
    if (control.evaluate(seen, frame_.exposure, {}, next, event) == ExposureControl::Answer::keep) continue;
    ASSERT_TRUE(camera_->set_exposure(next).ok());
    control.asked(next);
  }
  EXPECT_NEAR(seen.bright, 190, 190 / 7 + 4);
  EXPECT_LT(seen.white_permille, 10);
}

}  // namespace
}  // namespace ilp::sil
