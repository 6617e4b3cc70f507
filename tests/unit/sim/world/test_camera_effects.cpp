// Each effect of a camera against its definition, alone.

#include "sim/world/camera_effects.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "fsw/vision/geometry/camera.hpp"
#include "sim/world/lens.hpp"
#include "sim/world/ray_cast.hpp"
#include "sim/world/renderer.hpp"
#include "sim/world/sensor.hpp"
#include "tests/support/said.hpp"

namespace ilp::world {
namespace {

constexpr double altitude = 100;

CameraModel small_camera() {
  CameraModel camera{240, 180, 200, 200, 119.5, 89.5};
  return camera;
}

/// Straight down, image x along the world's x.
CameraMotion nadir() {
  CameraMotion motion;
  motion.state.rotation = Vec3(1, -1, -1).asDiagonal();
  motion.state.centre = Vec3(30, 20, altitude);
  return motion;
}

WorldParams flat(double albedo_contrast) {
  WorldParams world{.relief_m = 1e-6, .crater_density = 0, .rock_density = 0, .albedo_contrast = albedo_contrast};
  return world;
}

RenderedFrame render(const WorldParams& world, const CameraEffects& effects, const CameraMotion& motion = nadir(),
                     std::int64_t frame_index = 0, const CameraModel& camera = small_camera()) {
  const Terrain terrain(world);
  RenderedFrame frame;
  Renderer(terrain, camera, effects, 9).render(motion, frame_index, frame);
  return frame;
}

CameraMotion nadir_at(double time_s) {
  CameraMotion motion = nadir();
  motion.state.time_ns = static_cast<std::int64_t>(1e9 * time_s);
  return motion;
}

double radiance(std::uint8_t grey) {
  return grey / (255.0 - grey);
}

struct Moments {
  double mean = 0, variance = 0;
};

Moments moments(const std::vector<std::uint8_t>& values) {
  Moments result;
  for (const std::uint8_t value : values) result.mean += value / static_cast<double>(values.size());
  for (const std::uint8_t value : values) {
    result.variance += (value - result.mean) * (value - result.mean) / static_cast<double>(values.size() - 1);
  }
  return result;
}

/// Every effect with a value that shows.
std::vector<std::pair<std::string, std::function<void(CameraEffects&)>>> effects_one_by_one() {
  return {
      {"vignetting", [](CameraEffects& e) { e.vignetting = 0.4; }},
      {"motion blur", [](CameraEffects& e) { e.exposure_s = 0.4; }},
      {"rolling shutter", [](CameraEffects& e) { e.readout_s = 0.5; }},
      {"point spread", [](CameraEffects& e) { e.psf_sigma_px = 0.8; }},
      {"gain", [](CameraEffects& e) { e.gain = 1.3; }},
      {"gain walk", [](CameraEffects& e) { e.gain_step = 0.1; }},
      {"shot noise", [](CameraEffects& e) { e.shot_noise = true; }},
      {"read noise", [](CameraEffects& e) { e.read_noise_grey = 2; }},
      {"dead pixels", [](CameraEffects& e) { e.dead_pixel_share = 0.01; }},
      {"haze", [](CameraEffects& e) { e.haze = 0.3; }},
  };
}

CameraMotion moving() {
  CameraMotion motion = nadir();
  motion.velocity_m_s = Vec3(6, -3, 0.5);
  motion.turn_rad_s = Vec3(0.02, -0.03, 0.05);
  return motion;
}

// Four rays per pixel cast one at a time, and the response written out.
TEST(CameraEffects, AllOffIsThePlainAverageOfFourRays) {
  const CameraModel camera = small_camera();
  const CameraMotion motion = moving();
  const RenderedFrame frame = render({}, {}, motion);
  const Terrain terrain{WorldParams()};
  const SurfacePatch patch = terrain.patch({-80, -80, 140, 120});
  const RayCaster caster(patch);
  std::size_t off = 0, count = 0;
  for (int v = 3; v < camera.height; v += 7) {
    for (int u = 2; u < camera.width; u += 5, ++count) {
      double light = 0;
      for (const double dv : {-0.25, 0.25}) {
        for (const double du : {-0.25, 0.25}) {
          const Vec3 d = motion.state.rotation.transpose() *
                         Vec3((u + du - camera.cx) / camera.fx, (v + dv - camera.cy) / camera.fy, 1);
          const double t = caster.hit(motion.state.centre, d);
          const Vec3 p = motion.state.centre + t * d;
          const double x = p.x() / patch.spacing_m - patch.first_i, y = p.y() / patch.spacing_m - patch.first_j;
          const auto i = static_cast<std::int32_t>(x), j = static_cast<std::int32_t>(y);
          const auto post = [&](int di, int dj) {
            return static_cast<double>(patch.radiance[patch.index(i + di, j + dj)]);
          };
          light += 0.25 * terrain.detail(p.x(), p.y(), p.z(), t / camera.fx) *
                   ((1 - y + j) * ((1 - x + i) * post(0, 0) + (x - i) * post(1, 0)) +
                    (y - j) * ((1 - x + i) * post(0, 1) + (x - i) * post(1, 1)));
        }
      }
      const double grey = 255 * light / (1 + light);
      ASSERT_NEAR(frame.grey.at(u, v), grey, 0.5 + 1e-3) << u << "," << v;
      off += std::lround(grey) != frame.grey.at(u, v);
    }
  }
  EXPECT_LT(off, count / 100);
}

TEST(CameraEffects, EachAloneChangesTheImageAndLeavesTheDepth) {
  const Terrain terrain{WorldParams()};
  RenderedFrame plain, frame;
  Renderer(terrain, small_camera(), {}, 9).render(moving(), 40, plain);
  for (const auto& [name, turn_on] : effects_one_by_one()) {
    CameraEffects effects;
    turn_on(effects);
    Renderer(terrain, small_camera(), effects, 9).render(moving(), 40, frame);
    EXPECT_NE(frame.grey.samples, plain.grey.samples) << name;
    EXPECT_EQ(frame.depth_m.samples, plain.depth_m.samples) << name;
  }
}

TEST(CameraEffects, SameSeedIsTheSameBytesOnAnyNumberOfThreads) {
  CameraEffects effects;
  for (const auto& [name, turn_on] : effects_one_by_one()) turn_on(effects);
  const Terrain terrain{WorldParams()};
  const Renderer renderer(terrain, small_camera(), effects, 9);
  constexpr std::size_t frames = 6;
  std::vector<RenderedFrame> alone(frames), together(frames);
  const auto at = [](std::size_t k) {
    CameraMotion motion = moving();
    motion.state.centre.x() += 9.0 * static_cast<double>(k);
    return motion;
  };
  for (std::size_t k = frames; k-- > 0;) renderer.render(at(k), static_cast<std::int64_t>(k), alone[k]);
  {
    const Terrain fresh{WorldParams()};
    const Renderer shared(fresh, small_camera(), effects, 9);
    std::vector<std::jthread> threads;
    for (std::size_t k = 0; k < frames; ++k) {
      threads.emplace_back([&, k] { shared.render(at(k), static_cast<std::int64_t>(k), together[k]); });
    }
    threads.clear();
    for (std::size_t k = 0; k < frames; ++k) {
      EXPECT_EQ(alone[k].grey.samples, together[k].grey.samples) << k;
      EXPECT_EQ(alone[k].depth_m.samples, together[k].depth_m.samples) << k;
    }
  }
}

TEST(CameraEffects, VarianceOfShotNoiseGrowsWithTheLight) {
  CameraEffects effects{.full_well_e = 800, .shot_noise = true};
  for (const double gain : {0.2, 0.5, 1.0, 2.0, 5.0}) {
    effects.gain = gain;
    const Moments m = moments(render(flat(0), effects).grey.samples);
    const double level = 255 * gain / (1 + gain);
    EXPECT_NEAR(m.mean, level, 0.15);
    EXPECT_NEAR((m.variance - 1.0 / 12) / level, 255.0 / 800, 0.03 * 255 / 800) << "gain " << gain;
  }
}

TEST(CameraEffects, NoiseOfOneFrameSaysNothingAboutAnother) {
  CameraEffects effects{.full_well_e = 800, .shot_noise = true};
  const RenderedFrame a = render(flat(0), effects, nadir(), 0);
  const RenderedFrame b = render(flat(0), effects, nadir(), 1);
  double product = 0, squares = 0;
  for (std::size_t k = 0; k < a.grey.samples.size(); ++k) {
    product += (a.grey.samples[k] - 127.5) * (b.grey.samples[k] - 127.5);
    squares += (a.grey.samples[k] - 127.5) * (a.grey.samples[k] - 127.5);
  }
  EXPECT_LT(std::fabs(product / squares), 0.02);
}

TEST(CameraEffects, PointSpreadWidensAnEdgeByItsSigma) {
  for (const double sigma : {0.6, 1.0, 2.5}) {
    for (const bool across : {true, false}) {
      host::Raster<float> edge(81, 81, 1.0F);
      for (int y = 0; y < 81; ++y) {
        for (int x = 0; x < 81; ++x) edge.at(x, y) = (across ? x : y) >= 41 ? 3.0F : 1.0F;
      }
      blur(edge, sigma);
      double weight = 0, mean = 0, square = 0;
      for (int k = 0; k + 1 < 81; ++k) {
        const double step = across ? edge.at(k + 1, 13) - edge.at(k, 13) : edge.at(13, k + 1) - edge.at(13, k);
        weight += step;
        mean += step * (k + 0.5);
        square += step * (k + 0.5) * (k + 0.5);
      }
      EXPECT_NEAR(weight, 2, 1e-5);
      EXPECT_NEAR(mean / weight, 40.5, 1e-4);
      EXPECT_NEAR(std::sqrt(square / weight - mean * mean / (weight * weight)), sigma, 0.01 * sigma);
    }
  }
}

TEST(CameraEffects, VignettingFollowsTheFourthPowerOfTheCosine) {
  CameraEffects effects{.vignetting = 0.35};
  CameraModel camera = small_camera();
  camera.cx = 100;
  camera.cy = 80;
  const RenderedFrame frame = render(flat(0), effects, nadir(), 0, camera);
  const auto cosine4 = [&](double u, double v) {
    const double r2 = ((u - 100) * (u - 100) + (v - 80) * (v - 80)) / (200.0 * 200.0);
    return 1 / ((1 + r2) * (1 + r2));
  };
  EXPECT_NEAR(frame.grey.at(100, 80), 127.5, 0.6);
  EXPECT_NEAR(radiance(frame.grey.at(239, 179)) / radiance(frame.grey.at(100, 80)), 0.65, 0.01);
  for (int v = 0; v < 180; v += 9) {
    for (int u = 0; u < 240; u += 9) {
      const double light = 1 - 0.35 * (1 - cosine4(u, v)) / (1 - cosine4(239, 179));
      ASSERT_NEAR(frame.grey.at(u, v), 255 * light / (1 + light), 0.51) << u << "," << v;
    }
  }
}

TEST(CameraEffects, GainMultipliesTheLight) {
  for (const double gain : {0.1, 0.7, 3.0}) {
    CameraEffects effects{.gain = gain};
    EXPECT_NEAR(moments(render(flat(0), effects).grey.samples).mean, 255 * gain / (1 + gain), 0.51);
  }
}

TEST(CameraEffects, GainWalksInBoundedStepsThroughItsRange) {
  for (const double step : {0.01, 0.1, 0.5}) {
    CameraEffects effects{.gain_step = step};
    double least = 1, most = 1, largest = 0;
    for (std::int64_t k = 0; k < 40000; ++k) {
      const double now = frame_gain(effects, 4, k);
      const double next = frame_gain(effects, 4, k + 1);
      least = std::min(least, now);
      most = std::max(most, now);
      largest = std::max(largest, std::fabs(next / now - 1));
    }
    EXPECT_LE(largest, step * (1 + 1e-9));
    EXPECT_GT(largest, 0.5 * step);
    EXPECT_GE(least, 1.0 / 3);
    EXPECT_LE(most, 3);
    EXPECT_LT(least, 0.5);
    EXPECT_GT(most, 2);
    EXPECT_NE(frame_gain(effects, 4, 17), frame_gain(effects, 5, 17));
  }
}

TEST(CameraEffects, DeadPixelsAreTheSameInEveryFrame) {
  CameraEffects effects{.dead_pixel_share = 0.02};
  std::vector<std::set<std::size_t>> dead;
  std::set<int> levels;
  for (const double gain : {0.5, 2.0}) {
    effects.gain = gain;
    const RenderedFrame frame = render(flat(0), effects, nadir(), gain < 1 ? 3 : 8);
    const double level = 255 * gain / (1 + gain);
    dead.emplace_back();
    for (std::size_t k = 0; k < frame.grey.samples.size(); ++k) {
      if (std::fabs(frame.grey.samples[k] - level) > 1.5) dead.back().insert(k);
    }
  }
  std::set<std::size_t> both;
  std::set_intersection(dead[0].begin(), dead[0].end(), dead[1].begin(), dead[1].end(),
                        std::inserter(both, both.begin()));
  const double count = 240.0 * 180.0;
  EXPECT_NEAR(static_cast<double>(both.size()) / count, 0.02, 0.002);
  EXPECT_GT(static_cast<double>(both.size()), 0.97 * static_cast<double>(dead[0].size()));  // some sit at its level
}

// Koschmieder's law, with the haze along each ray integrated in small steps.
TEST(CameraEffects, HazeTakesContrastWithTheLengthOfTheWayThroughIt) {
  CameraMotion motion = nadir();
  motion.state.rotation = Eigen::AngleAxisd(0.5, Vec3::UnitX()).toRotationMatrix() * motion.state.rotation;
  const RenderedFrame clear = render(flat(0.6), {}, motion);
  for (const double scale_height : {0.0, 25.0}) {
    CameraEffects effects{.haze = 0.4, .haze_scale_height_m = scale_height};
    const RenderedFrame hazy = render(flat(0.6), effects, motion);
    const auto column = [&](double slant) {  // from the ground up to the camera
      double sum = 0;
      for (int k = 0; k < 1000; ++k) {
        const double z = (k + 0.5) * altitude / 1000;
        sum += slant * (scale_height > 0 ? std::exp(-z / scale_height) : 1);
      }
      return sum;
    };
    for (int v = 0; v < 180; v += 7) {
      for (int u = 0; u < 240; u += 7) {
        const Vec3 d = motion.state.rotation.transpose() * Vec3((u - 119.5) / 200, (v - 89.5) / 200, 1);
        const double transmission = std::pow(0.6, column(d.norm() / -d.z()) / column(1));
        const double light = 1 + (radiance(clear.grey.at(u, v)) - 1) * transmission;
        ASSERT_NEAR(hazy.grey.at(u, v), 255 * light / (1 + light), 1.01) << u << "," << v;
      }
    }
  }
}

// Row by row, the image is the one that a frozen camera takes where the moving one is when the row is read.
TEST(CameraEffects, RollingShutterReadsEachRowInItsTime) {
  CameraEffects effects{.readout_s = 0.8};
  const CameraMotion motion = moving();
  const RenderedFrame rolling = render({}, effects, motion);
  for (const int v : {0, 40, 90, 133, 179}) {
    const double dt = 0.8 * (v / 179.0 - 0.5);
    CameraMotion frozen;
    frozen.state.centre = motion.state.centre + dt * motion.velocity_m_s;
    const double angle = motion.turn_rad_s.norm();
    frozen.state.rotation =
        Eigen::AngleAxisd(dt * angle, motion.turn_rad_s / angle).toRotationMatrix() * motion.state.rotation;
    const RenderedFrame expected = render({}, {}, frozen);
    for (int u = 0; u < 240; ++u) ASSERT_NEAR(rolling.grey.at(u, v), expected.grey.at(u, v), 1) << u << "," << v;
  }
}

/// Shift in x of b's row against a's row, px, with sub-pixel interpolation of the sum of squares.
double row_shift(const host::Raster<std::uint8_t>& a, const host::Raster<std::uint8_t>& b, int v) {
  const auto cost = [&](int shift) {
    double sum = 0;
    for (int u = 30; u < 210; ++u) sum += std::pow(static_cast<double>(a.at(u, v)) - b.at(u + shift, v), 2);
    return sum;
  };
  int best = -29;
  for (int shift = -29; shift < 30; ++shift) best = cost(shift) < cost(best) ? shift : best;
  const double before = cost(best - 1), at = cost(best), after = cost(best + 1);
  return best + 0.5 * (before - after) / (before - 2 * at + after);
}

TEST(CameraEffects, RollingShutterShearsByVelocityTimesReadout) {
  CameraEffects effects{.readout_s = 1.5};
  CameraMotion motion = nadir();
  motion.velocity_m_s = Vec3(8, 0, 0);
  const RenderedFrame frozen = render(flat(0.6), {}, motion);
  const RenderedFrame rolling = render(flat(0.6), effects, motion);
  for (int v = 0; v < 180; v += 20) {
    // The ground moves back in the image as the camera moves on.
    const double expected = -8.0 * 1.5 * (v / 179.0 - 0.5) * 200 / altitude;
    EXPECT_NEAR(row_shift(frozen.grey, rolling.grey, v), expected, 0.15) << v;
  }
}

TEST(CameraEffects, MotionBlurIsTheMeanOfTheMomentsOfTheExposure) {
  CameraEffects effects{.exposure_s = 0.3};
  const CameraMotion motion = moving();
  const RenderedFrame blurred = render({}, effects, motion);
  std::vector<double> light(blurred.grey.samples.size(), 0.0);
  constexpr int moments_taken = 40;
  const Terrain terrain{WorldParams()};
  const Renderer renderer(terrain, small_camera(), {}, 9);
  RenderedFrame moment;
  for (int k = 0; k < moments_taken; ++k) {
    const double dt = 0.3 * ((k + 0.5) / moments_taken - 0.5);
    const double angle = motion.turn_rad_s.norm();
    CameraMotion frozen;
    frozen.state.centre = motion.state.centre + dt * motion.velocity_m_s;
    frozen.state.rotation =
        Eigen::AngleAxisd(dt * angle, motion.turn_rad_s / angle).toRotationMatrix() * motion.state.rotation;
    renderer.render(frozen, 0, moment);
    for (std::size_t p = 0; p < light.size(); ++p) light[p] += radiance(moment.grey.samples[p]) / moments_taken;
  }
  double bias = 0, mean = 0, largest = 0;
  for (std::size_t p = 0; p < light.size(); ++p) {
    const double off = blurred.grey.samples[p] - 255 * light[p] / (1 + light[p]);
    bias += off / static_cast<double>(light.size());
    mean += std::fabs(off) / static_cast<double>(light.size());
    largest = std::max(largest, std::fabs(off));
  }
  EXPECT_LT(std::fabs(bias), 0.1);
  EXPECT_LT(mean, 1.5);    // sixteen rays a pixel here, a hundred and sixty there
  EXPECT_LT(largest, 12);  // where a rock's edge passes
}

// Against the frozen image averaged over a length: the right one fits, shorter and longer ones do not.
TEST(CameraEffects, MotionBlurIsAsLongAsTheWayDuringTheExposure) {
  CameraEffects effects{.exposure_s = 0.5};
  for (const double length_px : {8.0, 20.0}) {
    CameraMotion motion = nadir();
    motion.velocity_m_s = Vec3(length_px * altitude / 200 / 0.5, 0, 0);
    const RenderedFrame frozen = render(flat(0.6), {}, motion);
    const RenderedFrame blurred = render(flat(0.6), effects, motion);
    const auto misfit = [&](double length) {
      double sum = 0;
      for (int v = 5; v < 180; v += 5) {
        for (int u = 20; u < 220; ++u) {
          double light = 0;
          for (int k = 0; k < 200; ++k) {
            const double x = u + length * ((k + 0.5) / 200 - 0.5);
            const int i = static_cast<int>(std::floor(x));
            light +=
                ((i + 1 - x) * radiance(frozen.grey.at(i, v)) + (x - i) * radiance(frozen.grey.at(i + 1, v))) / 200;
          }
          sum += std::fabs(blurred.grey.at(u, v) - 255 * light / (1 + light));
        }
      }
      return sum / (35 * 200);
    };
    EXPECT_LT(misfit(length_px), 0.7) << length_px;
    EXPECT_GT(misfit(0.8 * length_px), 1.3 * misfit(length_px)) << length_px;
    EXPECT_GT(misfit(1.2 * length_px), 1.3 * misfit(length_px)) << length_px;
  }
}

TEST(CameraEffects, ValueOutOfRangeIsNamed) {
  const Terrain terrain{WorldParams()};
  CameraEffects effects{.haze = 1};
  const auto make = [&] { const Renderer renderer(terrain, small_camera(), effects, 1); };
  EXPECT_TRUE(test::says(test::error_of<std::invalid_argument>(make), "haze"));
}

TEST(CameraEffects, EveryFieldIsAParameter) {
  CameraEffects effects;
  const std::vector<Parameter> all = parameters(effects);
  check_parameters(all, "camera");
  for (const auto& [name, value] :
       {std::pair{"vignetting", "0.5"}, {"exposure_s", "0.5"},    {"readout_s", "0.5"},
        {"psf_sigma_px", "0.5"},        {"gain", "0.5"},          {"gain_step", "0.5"},
        {"full_well_e", "50"},          {"shot_noise", "true"},   {"read_noise_grey", "0.5"},
        {"dead_pixel_share", "0.5"},    {"haze", "0.5"},          {"haze_scale_height_m", "0.5"},
        {"settable_us", "0.5"},         {"first_us", "0.5"},      {"obeys_after", "0.5"},
        {"light_from_s", "0.5"},        {"light_for_s", "0.5"},   {"light_every_s", "0.5"},
        {"light_share", "0.5"},         {"saturates", "true"},    {"cloud_from_s", "0.5"},
        {"cloud_for_s", "0.5"},         {"cloud_every_s", "0.5"}, {"cloud_opacity", "0.5"}}) {
    set_parameter(all, "camera", name, value);
  }
  EXPECT_EQ(all.size(), 24U);
  EXPECT_EQ(effects.vignetting + effects.exposure_s + effects.readout_s + effects.psf_sigma_px + effects.gain +
                effects.gain_step + effects.read_noise_grey + effects.dead_pixel_share + effects.haze +
                effects.haze_scale_height_m + effects.cloud_from_s + effects.cloud_for_s + effects.cloud_every_s +
                effects.cloud_opacity + effects.settable_us + effects.first_us + effects.obeys_after +
                effects.light_from_s + effects.light_for_s + effects.light_every_s + effects.light_share,
            10.5);
  EXPECT_TRUE(effects.shot_noise);
  EXPECT_TRUE(effects.saturates);
  EXPECT_EQ(effects.full_well_e, 50);
}

TEST(CameraEffects, CloudsComeAndGoAtTheirTimes) {
  CameraEffects effects{.cloud_from_s = 10, .cloud_for_s = 4, .cloud_opacity = 0.9};
  const auto at = [&](double time_s) { return cloud_at(effects, std::llround(1e9 * time_s)); };
  for (const double time_s : {0.0, 9.9, 14.0, 40.0}) EXPECT_EQ(at(time_s), 0) << time_s;
  for (const double time_s : {10.0, 13.9}) EXPECT_EQ(at(time_s), 0.9) << time_s;
  effects.cloud_every_s = 15;
  for (const double time_s : {0.0, 9.9, 14.1, 24.9, 29.1, 84.9}) EXPECT_EQ(at(time_s), 0) << time_s;
  for (const double time_s : {10.1, 13.9, 25.1, 28.9, 85.1}) EXPECT_EQ(at(time_s), 0.9) << time_s;
}

TEST(CameraEffects, CloudReplacesItsShareOfTheLightByEvenLight) {
  const WorldParams world = flat(0.6);
  const RenderedFrame clear = render(world, {}, nadir_at(0));
  CameraEffects effects{.cloud_for_s = 10, .cloud_every_s = 20, .cloud_opacity = 0.75};
  const RenderedFrame thin = render(world, effects, nadir_at(5));
  for (std::size_t k = 0; k < clear.grey.samples.size(); ++k) {
    const double expected = 0.25 * radiance(clear.grey.samples[k]) + 0.75;
    ASSERT_NEAR(thin.grey.samples[k], 255 * expected / (expected + 1), 1);
  }
  EXPECT_EQ(thin.depth_m.samples, clear.depth_m.samples) << "the ground shines through";
  EXPECT_EQ(render(world, effects, nadir_at(15)).grey.samples, clear.grey.samples);
  effects.cloud_opacity = 1;
  const RenderedFrame hidden = render(world, effects, nadir_at(5));
  for (std::size_t k = 0; k < hidden.grey.samples.size(); ++k) {
    ASSERT_EQ(hidden.grey.samples[k], hidden.grey.samples[0]);
    ASSERT_EQ(hidden.depth_m.samples[k], 0);
  }
}

}  // namespace
}  // namespace ilp::world
