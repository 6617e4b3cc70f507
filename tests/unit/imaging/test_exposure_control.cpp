// The exposure control in a closed loop with a sensor whose light, response and delay are known.
#include "fsw/imaging/exposure_control.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <random>
#include <vector>

namespace ilp {
namespace {

constexpr std::int32_t side = 80;

/// Looks at ground whose radiance grows evenly from a twentieth to one. In light 1, `white_us` at gain 1 is just white.
struct Sensor {
  double light = 1;
  double white_us = 4000;
  double noise_grey = 0;
  double gamma = 1;       ///< grey grows with this power of the light
  bool decibels = false;  ///< a gain of n is 3 (n - 1) dB in truth
  int delay = 0;          ///< images after a setting that still have the earlier one
  bool obeys = true;
  bool responds_at_once = true;  ///< it says the new setting of images that have the earlier one
  ExposureRange range{
      .least_us = 10, .most_us = 100'000, .step_us = 10, .least_gain_milli = 1000, .most_gain_milli = 16'000};
  ExposureSetting in_force{4000, 1000}, reported{4000, 1000};
  struct OnItsWay {
    ExposureSetting setting;
    int images = 0;  ///< that are still taken before it, after the one ahead of it
  };
  std::deque<OnItsWay> on_their_way;
  std::mt19937 random{7};

  /// Grey before it is cut at white.
  [[nodiscard]] double grey(double radiance) const {
    const double gain = 1e-3 * static_cast<double>(in_force.gain_milli);
    const double amplified = decibels ? std::pow(10.0, 3 * (gain - 1) / 20) : gain;
    const double share = light * radiance * static_cast<double>(in_force.exposure_us) / white_us * amplified;
    return 255 * std::pow(share, gamma);
  }
  void expose(std::vector<std::uint8_t>& pixels) {
    std::normal_distribution<double> noise(0, 1);
    pixels.resize(side * side);
    for (int k = 0; k < side * side; ++k) {
      const double radiance = 0.05 + 0.95 * k / (side * side - 1);
      const double noisy = grey(radiance) + noise_grey * noise(random);
      // Bright and dark pixels lie in every row.
      pixels[static_cast<std::size_t>(k % side) * side + static_cast<std::size_t>(k / side)] =
          static_cast<std::uint8_t>(std::clamp(std::floor(noisy + 0.5), 0.0, 255.0));
    }
    if (!obeys || on_their_way.empty()) return;
    if (--on_their_way.front().images > 0) return;
    in_force = on_their_way.front().setting;
    on_their_way.pop_front();
  }
  void set(const ExposureSetting& setting) {
    reported = setting;
    if (!obeys) return;
    int before = 0;
    for (const OnItsWay& other : on_their_way) before += other.images;
    if (before < delay) {
      on_their_way.push_back({setting, delay - before});
    } else if (delay > 0) {
      on_their_way.back().setting = setting;
    } else {
      in_force = setting;
    }
  }
};

struct Loop {
  Sensor sensor;
  ExposureGoal goal{.bright_grey = 190, .longest_us = 20'000, .most_gain_milli = 8000};
  ExposureControl control;
  std::vector<std::uint8_t> pixels;
  ImageBrightness seen;
  int changes = 0;
  std::vector<Status> events;

  void begin() { control.begin(sensor.range); }
  void fly(int images) {
    for (int i = 0; i < images; ++i) {
      const ExposureSetting truth = sensor.in_force;
      const ExposureSetting said = sensor.responds_at_once ? sensor.reported : truth;
      sensor.expose(pixels);
      seen = measure_brightness({pixels.data(), side, side, side});
      ExposureSetting next;
      Status event;
      const auto answer = control.evaluate(seen, said, goal, next, event);
      if (!event.ok()) events.push_back(event);
      if (answer == ExposureControl::Answer::keep) continue;
      ++changes;
      EXPECT_GE(next.exposure_us, sensor.range.least_us);
      EXPECT_EQ((next.exposure_us - sensor.range.least_us) % sensor.range.step_us, 0) << "no step of the camera's";
      EXPECT_LE(next.exposure_us, std::max(goal.longest_us, sensor.range.least_us));
      EXPECT_GE(next.gain_milli, sensor.range.least_gain_milli);
      EXPECT_LE(next.gain_milli, std::min(goal.most_gain_milli, sensor.range.most_gain_milli));
      sensor.set(next);
      control.asked(next);
    }
  }
  /// Grey that a hundredth of the pixels exceeds in truth, from the scene and not from an image.
  [[nodiscard]] double true_bright() const { return sensor.grey(0.05 + 0.95 * 0.99); }
  void expect_settled(int images) {
    const int before = changes;
    fly(images);
    EXPECT_EQ(changes, before);
    EXPECT_GT(true_bright(), 190 * 7 / 8 - 3);
    EXPECT_LT(true_bright(), 190 * 8 / 7 + 3);
  }
};

TEST(ExposureControl, TheBrightEndOfAnImageIsTheGreyThatAHundredthReaches) {
  std::vector<std::uint8_t> pixels(side * side, 40);
  for (int k = 0; k < side; ++k) pixels[static_cast<std::size_t>(k) * side + 5] = 180;  // an eightieth
  for (int k = 0; k < 10; ++k) pixels[static_cast<std::size_t>(4 * k * side)] = 255;    // glints
  EXPECT_EQ(measure_brightness({pixels.data(), side, side, side}).bright, 180);
  EXPECT_EQ(measure_brightness({pixels.data(), side, side, side}).white_permille, 6);
  for (int k = 0; k < side; ++k) {
    for (int i = 0; i < 20; ++i) pixels[static_cast<std::size_t>(k) * side + 10 + static_cast<std::size_t>(i)] = 255;
  }
  EXPECT_EQ(measure_brightness({pixels.data(), side, side, side}).bright, 255);
  EXPECT_EQ(measure_brightness({pixels.data(), side, side, side}).white_permille, 256);
}

TEST(ExposureControl, TheExposureIsBoundedByTheTimeInWhichTheGroundMovesByTheBlur) {
  EXPECT_EQ(longest_exposure_us(0.5, 100, 20'000), 5000);
  EXPECT_EQ(longest_exposure_us(0.5, 0, 20'000), 20'000);
  EXPECT_EQ(longest_exposure_us(0.5, 1, 20'000), 20'000);
  EXPECT_EQ(longest_exposure_us(0.5, std::nan(""), 20'000), 20'000);
}

TEST(ExposureControl, ADarkStartAndAWhiteOneSettleAndStay) {
  for (const double light : {0.001, 0.02, 0.3, 1.0, 20.0, 300.0}) {
    SCOPED_TRACE(light);
    Loop loop;
    loop.sensor.light = light;
    loop.sensor.white_us = 400;
    loop.goal.longest_us = 100'000;
    loop.goal.most_gain_milli = 16'000;
    if (light >= 20) loop.sensor.range.least_us = 1;
    loop.sensor.range.step_us = 1;
    loop.begin();
    loop.fly(14);
    loop.expect_settled(30);
  }
}

TEST(ExposureControl, StepsOfTheLightAreFollowedWithinEightImages) {
  Loop loop;
  loop.begin();
  loop.fly(6);
  for (const double light : {8.0, 0.5, 4.0, 0.3, 1.0}) {
    SCOPED_TRACE(light);
    loop.sensor.light = light;
    loop.fly(8);
    loop.expect_settled(4);
  }
  EXPECT_TRUE(loop.events.empty());
}

TEST(ExposureControl, AfterAQuietTimeAJumpOfTheLightIsFollowedWithoutDamping) {
  Loop loop;
  loop.sensor.decibels = true;
  loop.goal.longest_us = 1500;
  loop.goal.most_gain_milli = 16'000;
  loop.begin();
  loop.fly(20);
  // Gain in decibels is found in damped steps, there and back.
  loop.sensor.light = 0.1;
  loop.fly(20);
  loop.expect_settled(20);
  const int before = loop.changes;
  loop.sensor.light = 1;
  loop.fly(14);
  EXPECT_LE(loop.changes - before, 2);
  loop.expect_settled(10);
}

TEST(ExposureControl, TheGainStaysLeastWhileTheExposureMayBeLonger) {
  Loop loop;
  loop.sensor.light = 0.25;
  loop.begin();
  loop.fly(10);
  EXPECT_EQ(loop.sensor.in_force.gain_milli, 1000);
  // The shortest exposure that brings the bright end to its goal, from the scene's radiance.
  const double wanted_us = 190.0 / 255 * 4000 / 0.25 / (0.05 + 0.95 * 0.99);
  EXPECT_NEAR(static_cast<double>(loop.sensor.in_force.exposure_us), wanted_us, wanted_us / 7);
}

TEST(ExposureControl, AFasterGroundMakesTheExposureShorterAndTheGainMakesUpForIt) {
  Loop loop;
  loop.sensor.light = 0.25;
  loop.begin();
  loop.fly(10);
  loop.goal.longest_us = longest_exposure_us(0.5, 250, 20'000);
  loop.fly(6);
  EXPECT_EQ(loop.sensor.in_force.exposure_us, 2000);
  const double wanted_gain = 190.0 / 255 * 4000 / 0.25 / (0.05 + 0.95 * 0.99) / 2000;
  EXPECT_NEAR(1e-3 * static_cast<double>(loop.sensor.in_force.gain_milli), wanted_gain, wanted_gain / 7);
  loop.expect_settled(10);
  // The ground slows down again: less noise.
  loop.goal.longest_us = 20'000;
  loop.fly(4);
  EXPECT_EQ(loop.sensor.in_force.gain_milli, 1000);
  loop.expect_settled(10);
}

void expect_limited(const Status& event, std::int64_t limit, std::int64_t exposure_us) {
  EXPECT_TRUE(event.is(StatusCode::exposure_limited));
  EXPECT_EQ(event.a, limit);
  EXPECT_EQ(event.b, exposure_us);
}

TEST(ExposureControl, WhatTheLimitsDoNotAllowIsReportedOnce) {
  Loop dark;
  dark.sensor.light = 0.001;
  dark.begin();
  dark.fly(30);
  ASSERT_EQ(dark.events.size(), 1U);
  expect_limited(dark.events[0], 1, 20'000);
  EXPECT_EQ(dark.sensor.in_force, (ExposureSetting{20'000, 8000}));
  EXPECT_FALSE(dark.control.abandoned());

  Loop bright;
  bright.sensor.light = 5000;
  bright.begin();
  bright.fly(30);
  ASSERT_EQ(bright.events.size(), 1U);
  expect_limited(bright.events[0], 2, 10);
  EXPECT_EQ(bright.sensor.in_force, (ExposureSetting{10, 1000}));
  // Dusk: the control goes on, and a second limit would be reported again.
  bright.sensor.light = 1;
  bright.fly(14);
  bright.expect_settled(10);
}

TEST(ExposureControl, ACameraThatObeysLateSettles) {
  for (const bool responds_at_once : {true, false}) {
    for (const int delay : {1, 2, 3}) {
      for (const double light : {0.1, 6.0}) {
        SCOPED_TRACE(std::to_string(delay) + " images late, light " + std::to_string(light) +
                     (responds_at_once ? ", and does not know it" : ", and knows it"));
        Loop loop;
        loop.sensor.delay = delay;
        loop.sensor.responds_at_once = responds_at_once;
        loop.begin();
        loop.fly(20);
        loop.sensor.light = light;
        loop.fly(60);
        EXPECT_FALSE(loop.control.abandoned());
        loop.expect_settled(30);
      }
    }
  }
}

TEST(ExposureControl, ACameraThatNeverObeysIsLeftAlone) {
  for (const bool responds_at_once : {true, false}) {
    SCOPED_TRACE(responds_at_once);
    Loop loop;
    loop.sensor.obeys = false;
    loop.sensor.responds_at_once = responds_at_once;
    loop.sensor.light = 0.3;
    loop.begin();
    loop.fly(40);
    ASSERT_EQ(loop.events.size(), 1U);
    EXPECT_TRUE(loop.events[0].is(StatusCode::exposure_not_obeyed));
    EXPECT_TRUE(loop.control.abandoned());
    EXPECT_LE(loop.changes, 3);
  }
}

TEST(ExposureControl, ACameraThatMissesASettingNowAndThenIsControlledOn) {
  Loop loop;
  loop.begin();
  loop.fly(10);
  for (int k = 0; k < 5; ++k) {
    SCOPED_TRACE(k);
    loop.sensor.light = k % 2 == 0 ? 0.4 : 1;
    loop.sensor.obeys = false;
    loop.fly(1);
    loop.sensor.obeys = true;
    loop.fly(20);
    EXPECT_FALSE(loop.control.abandoned());
    loop.expect_settled(4);
  }
}

TEST(ExposureControl, AnotherLawOfGainOrResponseSettlesToo) {
  for (const double gamma : {0.45, 1.0, 1.6}) {
    for (const bool decibels : {false, true}) {
      for (const double light : {0.02, 0.1, 3.0}) {
        SCOPED_TRACE(std::to_string(gamma) + (decibels ? " decibels " : " linear ") + std::to_string(light));
        Loop loop;
        loop.sensor.gamma = gamma;
        loop.sensor.decibels = decibels;
        loop.sensor.light = light;
        loop.sensor.range.most_gain_milli = 16'000;
        loop.goal.most_gain_milli = 16'000;
        loop.begin();
        loop.fly(60);
        loop.expect_settled(60);
      }
    }
  }
}

TEST(ExposureControl, WhereOnlyASteepGainIsLeftEachChangeIsWaitedFor) {
  // Decibels and a power of 1.6: what is right for a linear sensor goes much too far, there and back.
  Loop loop;
  loop.sensor.gamma = 1.6;
  loop.sensor.decibels = true;
  loop.goal.longest_us = 1500;
  loop.goal.most_gain_milli = 16'000;
  loop.begin();
  loop.fly(20);
  loop.sensor.light = 0.1;
  loop.fly(30);
  const int before = loop.changes;
  loop.fly(60);
  EXPECT_LT(loop.changes - before, 30);
}

TEST(ExposureControl, NoiseAndSmallChangesOfTheLightChangeNothing) {
  Loop loop;
  loop.sensor.noise_grey = 3;
  loop.begin();
  loop.fly(10);
  const int before = loop.changes;
  for (int k = 0; k < 100; ++k) {
    loop.sensor.light = 1 + 0.05 * std::sin(0.7 * k);
    loop.fly(1);
  }
  EXPECT_EQ(loop.changes, before);
}

TEST(ExposureControl, AnImageOfUnknownExposureIsNotJudged) {
  ExposureControl control;
  control.begin({.least_us = 10, .most_us = 1000});
  ExposureSetting next;
  Status event;
  EXPECT_EQ(control.evaluate({.bright = 20}, {}, {}, next, event), ExposureControl::Answer::keep);
  EXPECT_EQ(control.evaluate({.bright = 20}, {100, 1000}, {}, next, event), ExposureControl::Answer::change);
}

}  // namespace
}  // namespace ilp
