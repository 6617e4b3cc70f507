// The forecast against motions whose overlap is known in closed form, and against a made-up gusty wind.
#include "fsw/vision/forecast/capture_forecast.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "fsw/base/math.hpp"
#include "fsw/vision/overlap/overlap.hpp"

namespace ilp {
namespace {

constexpr std::int32_t width = 640;
constexpr std::int32_t height = 480;

TimeNs at_s(double seconds) {
  return std::llround(seconds * 1e9);
}

/// A camera over level ground: its place in ground pixels, its heading and the scale of its image.
struct View {
  double x = 0, y = 0, heading = 0, scale = 1;
};

Similarity2 similarity(const View& from, const View& to) {
  // z_view = scale exp(i heading) (ground - place), about the image's centre.
  const double s = to.scale / from.scale;
  const double r = to.heading - from.heading;
  const double dx = from.x - to.x;
  const double dy = from.y - to.y;
  const double c_to = to.scale * std::cos(to.heading);
  const double s_to = to.scale * std::sin(to.heading);
  const double d_x = c_to * dx - s_to * dy;
  const double d_y = s_to * dx + c_to * dy;
  const double cx = 0.5 * (width - 1);
  const double cy = 0.5 * (height - 1);
  const double c = s * std::cos(r);
  const double n = s * std::sin(r);
  return {s, r, cx + d_x - (c * cx - n * cy), cy + d_y - (n * cx + c * cy)};
}

constexpr double target_overlap = 0.82;

/// What the flight asks for, as one answer.
struct Forecast {
  bool known = false;
  TimeNs time_ns = 0;
  double overlap = 1, sigma = 0, speed_px_s = 0;
  bool reached = false;
};

Forecast forecast_capture(const ApparentPath& path, TimeNs earliest, TimeNs latest) {
  static MotionForecast motion;
  motion.fit(width, height, path, target_overlap);
  Forecast forecast{.known = motion.known()};
  if (!forecast.known) return forecast;
  forecast.time_ns = motion.time_of_target(earliest, latest);
  const MotionForecast::Overlap expected = motion.overlap_at(forecast.time_ns);
  forecast.overlap = expected.overlap;
  forecast.sigma = expected.sigma;
  forecast.speed_px_s = motion.speed_px_s();
  forecast.reached = expected.overlap <= target_overlap + 1e-4;
  return forecast;
}

double overlap(const View& from, const View& to) {
  return footprint_overlap(width, height, similarity(from, to));
}

template <typename Motion>
ApparentPath follow(Motion motion, const std::vector<double>& keyframes_s) {
  ApparentPath path;
  begin_path(at_s(keyframes_s[0]), path);
  for (std::size_t i = 1; i < keyframes_s.size(); ++i) {
    const Similarity2 b_from_a = similarity(motion(keyframes_s[i - 1]), motion(keyframes_s[i]));
    EXPECT_TRUE(extend_path(width, height, at_s(keyframes_s[i]), b_from_a, true, path));
    EXPECT_TRUE(select_place(at_s(keyframes_s[i]), path));
  }
  return path;
}

TEST(CaptureForecast, SteadyMotionAlongARowReachesTheTargetWhenArithmeticSays) {
  const auto motion = [](double t) { return View{12 * t, 0, 0, 1}; };
  const ApparentPath path = follow(motion, {0, 8, 17, 25});
  const Forecast forecast = forecast_capture(path, at_s(26), at_s(60));
  ASSERT_TRUE(forecast.reached);
  // 18 % of 640 px at 12 px/s.
  EXPECT_NEAR(1e-9 * static_cast<double>(forecast.time_ns), 25 + 0.18 * 640 / 12, 1e-3);
  EXPECT_NEAR(forecast.overlap, 0.82, 1e-5);
  EXPECT_NEAR(forecast.speed_px_s, 12, 1e-3);
}

TEST(CaptureForecast, FollowsATurningRisingBalloonOnAnyHeading) {
  const auto motion = [](double t) { return View{7 * t + 40, -9 * t, 1.0 + 0.02 * t, std::exp(-0.004 * t)}; };
  const ApparentPath path = follow(motion, {3, 10, 16, 24, 31});
  const Forecast forecast = forecast_capture(path, at_s(32), at_s(80));
  ASSERT_TRUE(forecast.reached);
  const double t = 1e-9 * static_cast<double>(forecast.time_ns);
  EXPECT_NEAR(overlap(motion(31), motion(t)), 0.82, 1e-4);
}

TEST(CaptureForecast, AFrameTakenOnTheWaySharpensTheForecast) {
  // The wind rises by half after the last keyframe: only the frame on the way can know.
  const auto motion = [](double t) { return View{10 * t + (t > 20 ? 5 * (t - 20) : 0), 0, 0, 1}; };
  ApparentPath path = follow(motion, {0, 10, 20});
  const double before = 1e-9 * static_cast<double>(forecast_capture(path, at_s(21), at_s(60)).time_ns);
  ASSERT_TRUE(extend_path(width, height, at_s(24), similarity(motion(20), motion(24)), true, path));
  const double after = 1e-9 * static_cast<double>(forecast_capture(path, at_s(25), at_s(60)).time_ns);
  const double true_time = 20 + 0.18 * 640 / 15;
  EXPECT_LT(std::fabs(after - true_time), 0.9 * std::fabs(before - true_time));
}

TEST(CaptureForecast, TheErrorBarCoversAWrongStampThatNobodyNoticed) {
  const auto motion = [](double t) { return View{10 * t, 0, 0, 1}; };
  ApparentPath path;
  begin_path(0, path);
  double previous = 0;
  for (const double t : {11.0, 22.0, 33.0, 44.0, 55.0, 66.0}) {
    const double stamp = t == 33 ? t + 6 : t;  // six seconds late
    ASSERT_TRUE(extend_path(width, height, at_s(stamp), similarity(motion(previous), motion(t)), true, path));
    ASSERT_TRUE(select_place(at_s(stamp), path));
    previous = t;
  }
  const Forecast forecast = forecast_capture(path, at_s(67), at_s(120));
  const double achieved = overlap(motion(66), motion(1e-9 * static_cast<double>(forecast.time_ns)));
  EXPECT_NEAR(achieved, forecast.overlap, 2.5 * forecast.sigma);
}

TEST(CaptureForecast, ADoubtfulTimeIsNotUsedAtAll) {
  const auto motion = [](double t) { return View{10 * t, 0, 0, 1}; };
  ApparentPath path;
  begin_path(0, path);
  ASSERT_TRUE(extend_path(width, height, at_s(11), similarity(motion(0), motion(11)), true, path));
  ASSERT_TRUE(select_place(at_s(11), path));
  ASSERT_TRUE(extend_path(width, height, at_s(40), similarity(motion(11), motion(22)), false, path));
  ASSERT_TRUE(select_place(at_s(40), path));
  const Forecast forecast = forecast_capture(path, at_s(23), at_s(120));
  EXPECT_NEAR(1e-9 * static_cast<double>(forecast.time_ns), 22 + 0.18 * 640 / 10, 0.01);
}

/// A gondola that swings under a steady drift, so strongly that the drift alone predicts little.
TEST(CaptureForecast, TheCamerasAttitudeTellsTheSwing) {
  double squares[2] = {};
  for (const bool tilt_known : {false, true}) {
    for (int phase = 0; phase < 12; ++phase) {
      const auto swing = [phase](double t) { return 40 * std::sin(2 * pi * (t / 21.3 + phase / 12.0)); };
      const auto motion = [&](double t) { return View{12 * t + swing(t), 0.5 * swing(t), 0, 1}; };
      const std::vector<double> keyframes = {0, 9, 17, 27, 36, 45, 55, 62, 71};
      ApparentPath path = follow(motion, keyframes);
      for (const double t : keyframes) {
        const double tilt = swing(t) - swing(0);
        if (tilt_known && !set_tilt(at_s(t), tilt, 0.5 * tilt, path)) ADD_FAILURE() << t;
      }
      const Forecast forecast = forecast_capture(path, at_s(72), at_s(110));
      const double error = overlap(motion(71), motion(1e-9 * static_cast<double>(forecast.time_ns))) - 0.82;
      squares[tilt_known ? 1 : 0] += error * error / 12;
    }
  }
  EXPECT_LT(std::sqrt(squares[1]), 0.5 * std::sqrt(squares[0]));
  EXPECT_LT(std::sqrt(squares[1]), 0.02);
}

TEST(CaptureForecast, AnAttitudeOfAnUnknownTimeIsRefused) {
  ApparentPath path;
  begin_path(at_s(5), path);
  EXPECT_FALSE(set_tilt(at_s(6), 1, 1, path));
  EXPECT_TRUE(set_tilt(at_s(5), 1, 1, path));
}

TEST(CaptureForecast, HoverNeverReachesTheTarget) {
  const auto motion = [](double) { return View{}; };
  const ApparentPath path = follow(motion, {0, 5, 10});
  const Forecast forecast = forecast_capture(path, at_s(11), at_s(70));
  EXPECT_TRUE(forecast.known);
  EXPECT_FALSE(forecast.reached);
  EXPECT_EQ(forecast.time_ns, at_s(70));
}

TEST(CaptureForecast, OnePlaceIsNoMotion) {
  ApparentPath path;
  begin_path(at_s(1), path);
  EXPECT_FALSE(forecast_capture(path, at_s(2), at_s(9)).known);
}

TEST(CaptureForecast, ATimeThatDoesNotIncreaseIsRefused) {
  ApparentPath path;
  begin_path(at_s(5), path);
  EXPECT_FALSE(extend_path(width, height, at_s(5), {}, true, path));
  EXPECT_FALSE(extend_path(width, height, at_s(4), {}, true, path));
  EXPECT_FALSE(extend_path(width, height, at_s(6), {0, 0, 0, 0}, true, path));
  EXPECT_EQ(path.points.size(), 1U);
}

/// Wind whose speed wanders (an Ornstein-Uhlenbeck process), integrated in small steps.
class Gusts {
 public:
  Gusts(unsigned seed, double mean, double deviation, double lasting_s)
      : random_(seed), mean_(mean), deviation_(deviation), lasting_s_(lasting_s) {
    for (double& gust : gust_) gust = deviation_ * normal_(random_);
  }
  View at(double t) {
    constexpr double step = 0.05;
    for (; time_ < t; time_ += step) {
      const double keep = std::exp(-step / lasting_s_);
      for (double& gust : gust_) {
        gust = keep * gust + std::sqrt(1 - keep * keep) * deviation_ * normal_(random_);
      }
      view_.x += (mean_ + gust_[0]) * step;
      view_.y += gust_[1] * step;
    }
    return view_;
  }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  double mean_, deviation_, lasting_s_;
  double gust_[2] = {};
  double time_ = 0;
  View view_;
};

struct GustyFlight {
  double mean = 0, deviation = 0, inside_two_sigma = 0;
};

GustyFlight fly_in_gusts(double deviation, double lasting_s) {
  double sum = 0, squares = 0, inside = 0;
  int n = 0;
  for (unsigned seed = 0; seed < 8; ++seed) {
    Gusts wind(seed, 13.75, deviation, lasting_s);  // 2.5 m/s at 0.18 m a pixel
    ApparentPath path;
    begin_path(0, path);
    View keyframe = wind.at(0);
    TimeNs now = 0;
    for (int k = 0; k < 60; ++k) {
      Forecast forecast = forecast_capture(path, now + at_s(0.5), now + at_s(30));
      if (!forecast.known) forecast.time_ns = now + at_s(4);
      const View view = wind.at(1e-9 * static_cast<double>(forecast.time_ns));
      const double achieved = overlap(keyframe, view);
      now = forecast.time_ns;
      EXPECT_TRUE(extend_path(width, height, now, similarity(keyframe, view), true, path));
      EXPECT_TRUE(select_place(now, path));
      keyframe = view;
      if (k < 4) continue;
      const double error = achieved - forecast.overlap;
      sum += error;
      squares += error * error;
      inside += std::fabs(error) < 2 * forecast.sigma ? 1 : 0;
      ++n;
    }
  }
  GustyFlight flight{.mean = sum / n};
  flight.deviation = std::sqrt(squares / n - flight.mean * flight.mean);
  flight.inside_two_sigma = inside / n;
  return flight;
}

TEST(CaptureForecast, InGustsTheOverlapStaysNearItsTargetAndTheErrorBarIsHonest) {
  // Gusts of a tenth of the wind, lasting from seconds to half a minute.
  for (const double lasting_s : {3.0, 10.0, 30.0}) {
    const GustyFlight flight = fly_in_gusts(0.1 * 13.75, lasting_s);
    EXPECT_LT(flight.deviation, 0.02) << lasting_s;
    EXPECT_LT(std::fabs(flight.mean), 0.005) << lasting_s;
    EXPECT_GT(flight.inside_two_sigma, 0.9) << lasting_s;
  }
}

}  // namespace
}  // namespace ilp
