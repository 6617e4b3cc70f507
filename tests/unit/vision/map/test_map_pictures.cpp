// Registration on a map made of one image of HiRISE, of keyframes made of another one of the same ground four years
// later, where these data are beside the project.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "fsw/base/math.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "sim/host/image_io.hpp"
#include "tests/support/read_image.hpp"
#include "tests/unit/vision/map/map_world.hpp"

namespace ilp::test {
namespace {
namespace fs = std::filesystem;

constexpr double picture_pixel_m = 0.2526;
// Of the map's picture over the other one, pixels: the README of the data.
constexpr double shift_column = 2.3, shift_row = -0.1;
constexpr int trials = ILP_MAP_KEYFRAMES < 20 ? 5 : 40;

/// The picture's north-western corner is (0, 0), and the ground level.
OrbitalMap map_of(const host::Raster<std::uint8_t>& picture, int factor) {
  OrbitalMap map;
  map.pixel_m = factor * picture_pixel_m;
  map.columns = picture.width / factor;
  map.rows = picture.height / factor;
  map.sun_elevation_rad = 0.7;
  for (std::int32_t row = 0; row < map.rows; ++row) {
    for (std::int32_t column = 0; column < map.columns; ++column) {
      double sum = 0;
      for (int j = 0; j < factor; ++j) {
        for (int i = 0; i < factor; ++i) sum += picture.at(factor * column + i, factor * row + j);
      }
      map.image.push_back(static_cast<std::uint8_t>(std::clamp(std::lround(sum / factor / factor), 1L, 255L)));
    }
  }
  map.height_m.assign(map.image.size(), 0);
  return map;
}

double grey_at(const host::Raster<std::uint8_t>& picture, double column, double row) {
  const double c = std::clamp(column, 0.0, picture.width - 1.001), r = std::clamp(row, 0.0, picture.height - 1.001);
  const auto x = static_cast<std::int32_t>(c), y = static_cast<std::int32_t>(r);
  const double fx = c - x, fy = r - y;
  return (1 - fy) * ((1 - fx) * picture.at(x, y) + fx * picture.at(x + 1, y)) +
         fy * ((1 - fx) * picture.at(x, y + 1) + fx * picture.at(x + 1, y + 1));
}

/// A camera over the middle of the picture, at any heading.
void look(const host::Raster<std::uint8_t>& picture, Rng& rng, MapTrial& trial) {
  constexpr double altitude_m = 97, place_m = 15, attitude_rad = 0.0087, height_m = 1;
  CameraModel& camera = trial.keyframe.camera;
  camera = {};
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 550;
  camera.cx = 319.5;
  camera.cy = 239.5;
  const Vec3 centre((295 + 16 * rng.uniform()) * picture_pixel_m, -(292 + 100 * rng.uniform()) * picture_pixel_m,
                    altitude_m);
  const Mat3 rotation = rotation_from_vector(Vec3(0, 0, 2 * pi * rng.uniform())) * Vec3(1, -1, -1).asDiagonal();
  trial.truth = {rotation, -(rotation * centre)};
  trial.ground = Vec3(centre.x(), centre.y(), 0);
  host::Raster<std::uint8_t>& image = trial.frame.grey;
  image = host::Raster<std::uint8_t>(camera.width, camera.height);
  for (std::int32_t v = 0; v < camera.height; ++v) {
    for (std::int32_t u = 0; u < camera.width; ++u) {
      const Vec3 ray = rotation.transpose() * Vec3((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1);
      const Vec3 ground = centre - centre.z() / ray.z() * ray;
      const double grey = grey_at(picture, ground.x() / picture_pixel_m - 0.5 - shift_column,
                                  -ground.y() / picture_pixel_m - 0.5 - shift_row);
      image.at(u, v) = static_cast<std::uint8_t>(std::lround(std::clamp(grey + 2 * normal(rng), 0.0, 255.0)));
    }
  }
  const Vec3 turn = attitude_rad * Vec3(normal(rng), normal(rng), normal(rng));
  const Vec3 moved =
      centre + Vec3(place_m * (2 * rng.uniform() - 1), place_m * (2 * rng.uniform() - 1), height_m * normal(rng));
  trial.prior.camera_from_map.rotation = rotation_from_vector(turn) * rotation;
  trial.prior.camera_from_map.translation = -(trial.prior.camera_from_map.rotation * moved);
  trial.prior.covariance.setZero();
  for (int k = 0; k < 3; ++k) trial.prior.covariance(k, k) = attitude_rad * attitude_rad;
  trial.prior.covariance(3, 3) = trial.prior.covariance(4, 4) = place_m * place_m / 3;
  trial.prior.covariance(5, 5) = height_m * height_m;
  trial.prior.attitude_is_measured = true;
  trial.keyframe.image = image.view();
  trial.keyframe.camera_from_map = trial.prior.camera_from_map;
}

TEST(ILP_MAP_PICTURE_SUITE, KeyframesOfOneImageOfMarsAreFixedOnAMapOfAnother) {
  const fs::path folder = fs::path(data_root) / "mars_hirise_pair_a";
  if (!fs::exists(folder / "before.png")) GTEST_SKIP() << "no " << folder;
  const host::Raster<std::uint8_t> before = host::read_gray(folder / "before.png"),
                                   after = host::read_gray(folder / "after.png");
  for (const int factor : {1, 2, 4, 8}) {
    const OrbitalMap map = map_of(before, factor), mirror = mirrored(map);
    const SunDirection sun{map.sun_azimuth_rad, map.sun_elevation_rad};
    Rng rng(11, static_cast<std::uint64_t>(factor));
    WindowStore store;
    MapTrial trial;
    MapTally tally;
    int mirrored_fixes = 0;
    for (int k = 0; k < trials; ++k) {
      look(after, rng, trial);
      const MapPlan plan = plan_of(trial, map);
      tally.add(register_on_map(trial, plan, store.fill(map, plan), sun), trial, plan.pixel_m);
      const MapFixResult wrong = register_on_map(trial, plan, store.fill(mirror, plan), sun);
      mirrored_fixes += wrong.verdict == MapVerdict::fixed ? 1 : 0;
    }
    std::printf("map pixel %.2f m: fixed %d of %d, wrong %d, mirrored %d, ground %.2f and %.2f px, NEES / 3 %.2f\n",
                map.pixel_m, tally.fixed, tally.trials, tally.wrong, mirrored_fixes, tally.ground_quantile(0.5),
                tally.ground_quantile(0.95), tally.mean_nees());
    EXPECT_GE(tally.fixed, std::floor(0.95 * tally.trials)) << map.pixel_m;
    EXPECT_LE(tally.ground_quantile(0.5), 0.6) << map.pixel_m;
    EXPECT_EQ(tally.wrong, 0) << map.pixel_m;
    EXPECT_EQ(mirrored_fixes, 0) << map.pixel_m;
  }
}

}  // namespace
}  // namespace ilp::test
