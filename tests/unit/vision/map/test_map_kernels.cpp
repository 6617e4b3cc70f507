// The parts of the registration against a map, each against what is known without it.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "fsw/base/math.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/map/ground_point.hpp"
#include "fsw/vision/map/map_channels.hpp"
#include "fsw/vision/map/map_light.hpp"
#include "fsw/vision/map/map_pose.hpp"
#include "fsw/vision/map/map_registration.hpp"
#include "fsw/vision/map/map_repeats.hpp"
#include "fsw/vision/map/map_votes.hpp"
#include "fsw/vision/map/patch_search.hpp"
#include "tests/unit/vision/map/map_world.hpp"

namespace ilp::test {
namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;

/// A camera that looks down, tilted a little.
RigidTransform some_pose(Rng& rng, double height_m = 100) {
  RigidTransform pose;
  pose.rotation = rotation_from_vector(Vec3(0.2 * normal(rng), 0.2 * normal(rng), 0)) *
                  rotation_from_vector(Vec3(0, 0, 6 * rng.uniform())) * Vec3(1, -1, -1).asDiagonal();
  pose.translation = -(pose.rotation * Vec3(50 * normal(rng), 50 * normal(rng), height_m));
  return pose;
}

Vec6 unit_change(int k, double step) {
  Vec6 change = Vec6::Zero();
  change(k) = step;
  return change;
}

TEST(MapGround, DerivativesAreThoseOfDifferences) {
  Rng rng(1);
  for (int trial = 0; trial < 20; ++trial) {
    const RigidTransform pose = some_pose(rng);
    const Vec3 direction(0.3 * normal(rng), 0.3 * normal(rng), 1);
    Vec3 ground;
    ASSERT_TRUE(ground_on_level(pose, direction, 3, ground));
    EXPECT_NEAR(ground.z(), 3, 1e-9);
    const Eigen::Matrix<double, 2, 6> by = ground_by_pose(pose, ground);
    for (int k = 0; k < 6; ++k) {
      const double step = 1e-5;
      Vec3 ahead, behind;
      ASSERT_TRUE(ground_on_level(changed_pose(pose, unit_change(k, step)), direction, 3, ahead));
      ASSERT_TRUE(ground_on_level(changed_pose(pose, unit_change(k, -step)), direction, 3, behind));
      EXPECT_LT((by.col(k) - (ahead - behind).head<2>() / (2 * step)).norm(), 1e-4 * (1 + by.col(k).norm())) << k;
    }
  }
}

TEST(MapGround, ALineOfSightThatDoesNotLeadDownHasNone) {
  Rng rng(2);
  const RigidTransform pose = some_pose(rng);
  Vec3 ground;
  EXPECT_FALSE(ground_on_level(pose, Vec3(0, 0, -1), 0, ground));
  EXPECT_FALSE(ground_on_level(pose, Vec3(0, 0, 1), 200, ground));
}

/// A covariance that is the same along every axis, as that of a place found by features, has only rounding errors
/// across, of either sign.
TEST(MapGround, TheLargestSigmaBearsRounding) {
  Mat2 covariance;
  covariance << 13, 1e-15, -2e-15, 13;
  EXPECT_NEAR(largest_sigma(covariance), std::sqrt(13.0), 1e-9);
  covariance << 9, 2, 2, 6;
  EXPECT_NEAR(largest_sigma(covariance), std::sqrt(10.0), 1e-9);
}

TEST(MapPose, DerivativesAreThoseOfDifferences) {
  Rng rng(3);
  for (int trial = 0; trial < 20; ++trial) {
    const RigidTransform pose = some_pose(rng);
    MapSighting sighting;
    ASSERT_TRUE(ground_on_level(pose, Vec3(0.4 * normal(rng), 0.4 * normal(rng), 1), 0, sighting.place));
    sighting.at = Vec2(normal(rng), normal(rng));
    Vec2 residual, ahead, behind;
    Eigen::Matrix<double, 2, 6> by, unused;
    ASSERT_TRUE(sighting_residual(pose, sighting, residual, by));
    for (int k = 0; k < 6; ++k) {
      const double step = 1e-5;
      ASSERT_TRUE(sighting_residual(changed_pose(pose, unit_change(k, step)), sighting, ahead, unused));
      ASSERT_TRUE(sighting_residual(changed_pose(pose, unit_change(k, -step)), sighting, behind, unused));
      EXPECT_LT((by.col(k) - (ahead - behind) / (2 * step)).norm(), 1e-6) << k;
    }
  }
}

/// Sightings of rough ground by a pose, and a prior that errs.
struct PoseScene {
  RigidTransform truth;
  MapPrior prior;
  std::vector<MapSighting> sightings;
};
PoseScene pose_scene(Rng& rng, int count, double sigma_m, double outliers) {
  PoseScene scene{.truth = some_pose(rng)};
  scene.prior.attitude_is_measured = true;
  Vec6 error;
  for (int k = 0; k < 3; ++k) error(k) = 0.01 * normal(rng);
  for (int k = 3; k < 6; ++k) error(k) = 10 * normal(rng);
  scene.prior.camera_from_map = changed_pose(scene.truth, error);
  for (int k = 0; k < 6; ++k) scene.prior.covariance(k, k) = k < 3 ? 1e-4 : 100;
  for (int k = 0; k < count; ++k) {
    MapSighting sighting;
    const Vec3 direction(0.5 * (2 * rng.uniform() - 1), 0.4 * (2 * rng.uniform() - 1), 1);
    EXPECT_TRUE(ground_on_level(scene.truth, direction, 3 * normal(rng), sighting.place));
    sighting.at = direction.head<2>();
    const double far = rng.uniform() < outliers ? 20 : 1;
    sighting.place += far * sigma_m * Vec3(normal(rng), normal(rng), 0);
    scene.sightings.push_back(sighting);
  }
  return scene;
}

TEST(MapPose, ExactSightingsGiveTheExactPose) {
  Rng rng(4);
  for (int trial = 0; trial < 20; ++trial) {
    PoseScene scene = pose_scene(rng, 12, 0, 0);
    scene.prior.attitude_is_measured = false;
    MapPose pose;
    ASSERT_TRUE(solve_map_pose(scene.sightings, scene.prior, {0.8, 0.5, 1, 0, 0}, pose));
    EXPECT_LT(pose_change(pose.camera_from_map, scene.truth).norm(), 1e-6);
    EXPECT_LT(pose.residual_px, 1e-6);
  }
}

TEST(MapPose, WhatFitsWorseIsAlsoOffAsAWhole) {
  Rng rng(6);
  const PoseScene scene = pose_scene(rng, 40, 0.4, 0);
  const auto east_variance = [&scene](double share, double growth) {
    PoseScene copy = scene;
    MapPose pose;
    EXPECT_TRUE(solve_map_pose(copy.sightings, copy.prior, {0.8, 0.5, 1, share, growth}, pose));
    return pose.covariance(3, 3);
  };
  PoseScene copy = scene;
  MapPose pose;
  ASSERT_TRUE(solve_map_pose(copy.sightings, copy.prior, {0.8, 0.5, 1, 0, 0}, pose));
  EXPECT_NEAR(pose.residual_px, 0.4 / 0.8, 0.1);
  const double spread_m = 0.8 * pose.residual_px, own = pose.covariance(3, 3);
  EXPECT_NEAR(east_variance(0.5, 0) - own, 0.25 * spread_m * spread_m, 1e-9);
  const double grown = 0.6 * pose.residual_px * spread_m;
  EXPECT_NEAR(east_variance(0, 0.6) - own, grown * grown, 1e-9);
}

TEST(MapPose, ErrorsAreThoseThatTheCovarianceStates) {
  Rng rng(5);
  for (const double outliers : {0.0, 0.1}) {
    double position = 0, all = 0;
    constexpr int trials = 300;
    for (int trial = 0; trial < trials; ++trial) {
      PoseScene scene = pose_scene(rng, 40, 0.4, outliers);
      MapPose pose;
      ASSERT_TRUE(solve_map_pose(scene.sightings, scene.prior, {0.8, 0.5, 1, 0, 0}, pose));
      const Vec6 miss = pose_change(scene.truth, pose.camera_from_map);
      PoseCovariance inverse;
      Mat3 position_inverse;
      ASSERT_TRUE(invert_positive_definite<6>(pose.covariance, inverse));
      const Mat3 of_position = pose.covariance.bottomRightCorner<3, 3>();
      ASSERT_TRUE(invert_positive_definite<3>(of_position, position_inverse));
      const Vec3 moved = miss.tail<3>();
      position += moved.dot(position_inverse * moved) / 3 / trials;
      all += miss.dot(inverse * miss) / 6 / trials;
    }
    EXPECT_GT(position, 0.7);
    EXPECT_LT(position, 1.3);
    EXPECT_GT(all, 0.7);
    EXPECT_LT(all, 1.3);
  }
}

TEST(MapPose, PlacesOnALineGiveNoneWithoutAnAttitude) {
  Rng rng(6);
  PoseScene scene = pose_scene(rng, 12, 0, 0);
  for (std::size_t k = 0; k < scene.sightings.size(); ++k) {
    const Vec3 direction(0.05 * static_cast<double>(k) - 0.3, 0.1, 1);
    ASSERT_TRUE(ground_on_level(scene.truth, direction, 0, scene.sightings[k].place));
    scene.sightings[k].at = direction.head<2>();
  }
  scene.prior.attitude_is_measured = false;
  MapPose pose;
  EXPECT_FALSE(solve_map_pose(scene.sightings, scene.prior, {0.8, 0.5, 1, 0.1}, pose));
}

TEST(MapVotes, EvidenceIsThatOfTheBinomialDistribution) {
  for (const int patches : {6, 20, 63, 96}) {
    for (const double lags : {25.0 * 25, 41.0 * 41, 89.0 * 89}) {
      const long double p = 9 / static_cast<long double>(lags);
      for (int votes = 1; votes <= patches; votes += 5) {
        long double tail = 0;
        for (int k = patches; k >= votes; --k) {
          const long double ways =
              std::lgamma(patches + 1.0L) - std::lgamma(k + 1.0L) - std::lgamma(patches - k + 1.0L);
          tail += std::exp(ways + k * std::log(p) + (patches - k) * std::log1p(-p));
        }
        const auto expected = static_cast<double>(-std::log(tail) + std::log(p));
        EXPECT_NEAR(vote_evidence(votes, patches, lags), expected, 1e-7 * (1 + std::fabs(expected)));
      }
    }
  }
}

/// A workspace with a window and a sheet of noise, some of it unknown.
std::unique_ptr<MapRegistrationWorkspace> noisy_workspace(double unknown_share) {
  auto workspace = std::make_unique<MapRegistrationWorkspace>();
  Rng rng(8);
  const auto fill = [&](auto& channels, std::int32_t width, std::int32_t height, double unknown) {
    channels.width = width;
    channels.height = height;
    for (std::size_t k = 0; k < channels.at(0, height); ++k) {
      const bool known = rng.uniform() >= unknown;
      channels.value[k] =
          known ? static_cast<std::int16_t>(std::clamp(256 * normal(rng), -2047.0, 2047.0)) : unknown_value;
      channels.direction[2 * k] = known ? static_cast<std::int8_t>(rng.below(255)) : std::int8_t{0};
      channels.direction[2 * k + 1] = known ? static_cast<std::int8_t>(rng.below(255)) : std::int8_t{0};
    }
  };
  fill(workspace->window, 76, 71, unknown_share);
  fill(workspace->sheet, 40, 35, 0.05);
  return workspace;
}

/// Normalised correlation of what both know, in floating point.
double correlation(const MapRegistrationWorkspace& w, const MapPatch& patch, int side, int column, int row,
                   bool values) {
  double own_sum = 0, own_count = 0, map_sum = 0, map_count = 0;
  const auto value = [](std::int16_t v) { return v == unknown_value ? 0.0 : static_cast<double>(v); };
  const auto own_at = [&](int x, int y) { return w.sheet.at(patch.column + x, patch.row + y); };
  const auto map_at = [&](int x, int y) { return w.window.at(patch.column + column + x, patch.row + row + y); };
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      own_sum += value(w.sheet.value[own_at(x, y)]);
      own_count += w.sheet.value[own_at(x, y)] != unknown_value;
      map_sum += value(w.window.value[map_at(x, y)]);
      map_count += w.window.value[map_at(x, y)] != unknown_value;
    }
  }
  double products = 0, own_squares = 0, map_squares = 0;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const std::size_t a = own_at(x, y), b = map_at(x, y);
      if (values) {
        const double own = w.sheet.value[a] == unknown_value ? 0 : w.sheet.value[a] - own_sum / own_count;
        const double map = w.window.value[b] == unknown_value ? 0 : w.window.value[b] - map_sum / map_count;
        products += own * map;
        own_squares += own * own;
        map_squares += map * map;
      } else {
        for (std::size_t k = 0; k < 2; ++k) {
          products += w.sheet.direction[2 * a + k] * w.window.direction[2 * b + k];
          own_squares += w.sheet.direction[2 * a + k] * w.sheet.direction[2 * a + k];
          map_squares += w.window.direction[2 * b + k] * w.window.direction[2 * b + k];
        }
      }
    }
  }
  return products / std::sqrt(own_squares * map_squares);
}

/// All scores of a patch against the correlations; the scores of the narrower vectors are those of the wider ones.
void compare_scores(MapRegistrationWorkspace& workspace, const PatchSearch& search, double tolerance) {
  constexpr std::int32_t lags = 37;
  std::vector<std::int32_t> first;
  MapPatch patch;
  patch.column = 7;
  patch.row = 11;
  for (const VectorWidth width : {VectorWidth::bytes16, VectorWidth::bytes32}) {
    if (width == VectorWidth::bytes32 && widest_vectors() != VectorWidth::bytes32) continue;
    use_vectors(width);
    search_patch(patch, search, {0, 0, lags, lags}, workspace);
    std::vector<std::int32_t> scores;
    for (std::int32_t row = 0; row < lags; ++row) {
      for (std::int32_t column = 0; column < lags; ++column) {
        scores.push_back(workspace.surface[static_cast<std::size_t>(row * map_lag_stride + column)]);
        double expected = correlation(workspace, patch, search.side, column, row, false);
        if (search.value_share > 0) {
          expected +=
              static_cast<double>(search.value_share) * correlation(workspace, patch, search.side, column, row, true);
        }
        EXPECT_NEAR(scores.back() / double{map_score_one}, expected, tolerance) << column << " " << row;
      }
    }
    if (!first.empty()) {
      EXPECT_EQ(scores, first);
    }
    first = scores;
  }
  use_vectors(widest_vectors());
}

TEST(MapPatchSearch, ScoresAreCorrelationsInEveryWidth) {
  for (const double unknown_share : {0.0, 0.1}) {
    const auto workspace = noisy_workspace(unknown_share);
    for (const std::int32_t side : {16, 12, 8}) {
      compare_scores(*workspace, {side, 0}, 0.001);
      // What the map does not know is its mean there, not that of the cells behind the patch.
      compare_scores(*workspace, {side, 0.5F}, unknown_share > 0 ? 0.04 : 0.002);
      compare_scores(*workspace, {side, 1}, unknown_share > 0 ? 0.08 : 0.003);
    }
  }
}

TEST(MapPatchSearch, WhereTheMapKnowsLessThanHalfOfAPatchThereIsNoScore) {
  const auto workspace = noisy_workspace(0);
  for (std::int32_t row = 0; row < workspace->window.height; ++row) {
    for (std::int32_t column = 40; column < workspace->window.width; ++column) {
      workspace->window.value[workspace->window.at(column, row)] = unknown_value;
    }
  }
  MapPatch patch;
  constexpr std::int32_t lags = 37;
  search_patch(patch, {16, 0}, {0, 0, lags, lags}, *workspace);
  for (std::int32_t column = 0; column < lags; ++column) {
    const bool known = workspace->surface[static_cast<std::size_t>(column)] != unknown_score;
    EXPECT_EQ(known, column + 8 <= 40) << column;
  }
}

/// A window over ground of a plane, z = slope_x x + slope_y y.
struct PlaneWindow {
  std::vector<float> height;
  std::vector<std::uint8_t> image, known;
  MapWindow window;

  PlaneWindow(std::int32_t width, std::int32_t height_px, double pixel_m, double slope_x, double slope_y)
      : image(static_cast<std::size_t>(width) * static_cast<std::size_t>(height_px), 128), known(image.size(), 1) {
    window.width = width;
    window.height = height_px;
    window.pixel_m = pixel_m;
    window.x0_m = -0.5 * width * pixel_m;
    window.y0_m = 0.5 * height_px * pixel_m;
    for (std::int32_t r = 0; r < height_px; ++r) {
      for (std::int32_t c = 0; c < width; ++c) {
        const double x = window.x0_m + (c + 0.5) * pixel_m, y = window.y0_m - (r + 0.5) * pixel_m;
        height.push_back(static_cast<float>(slope_x * x + slope_y * y));
      }
    }
    window.image = image.data();
    window.known = known.data();
    window.height_m = height.data();
  }
};

TEST(MapLight, APlaneIsLitByItsNormal) {
  const double azimuth = 0.7, elevation = 0.6, ambient = 0.25;
  for (const auto& slope : {Vec2(0.3, 0), Vec2(0, 0.3), Vec2(-0.4, 0.2), Vec2(0, 0)}) {
    const PlaneWindow plane(8, 8, 2, slope.x(), slope.y());
    const Vec3 normal_of_plane = Vec3(-slope.x(), -slope.y(), 1).normalized();
    const Vec3 sun(std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
                   std::sin(elevation));
    const double expected = ambient + (1 - ambient) * normal_of_plane.dot(sun) / std::sin(elevation);
    Slope of_cell;
    ASSERT_TRUE(slope_of(plane.window, 3, 4, of_cell));
    EXPECT_NEAR(light_on(of_cell, lamp_of({azimuth, elevation}, ambient)), expected, 1e-6);
    EXPECT_FALSE(slope_of(plane.window, 0, 4, of_cell));
  }
}

TEST(MapLight, AzimuthsDifferByAtMostHalfACircle) {
  EXPECT_NEAR(azimuth_between(3.0, -3.0), 2 * pi - 6, 1e-12);
  EXPECT_NEAR(azimuth_between(0.5, 0.5 + 2 * pi), 0, 1e-12);
  EXPECT_NEAR(azimuth_between(0, pi), pi, 1e-12);
}

TEST(MapLight, RelightingUndoesTheMapsOwnLight) {
  // A map of even ground on a slope, imaged under one sun: under another one it has that one's light.
  PlaneWindow plane(8, 8, 2, 0.2, 0.1);
  const SunDirection then{0.3, 0.7}, now{1.1, 0.5};
  Slope slope;
  ASSERT_TRUE(slope_of(plane.window, 3, 3, slope));
  const double light_then = light_on(slope, lamp_of(then, 0.25)), light_now = light_on(slope, lamp_of(now, 0.25));
  for (std::uint8_t& grey : plane.image) grey = static_cast<std::uint8_t>(std::lround(128 * light_then));
  const auto channels = std::make_unique<MapChannels<max_map_window_side>>();
  channels->width = channels->height = 8;
  relight_rows(plane.window, {lamp_of(now, 0.25), lamp_of(then, 0.25)}, 0, 8, *channels);
  EXPECT_NEAR(channels->value[channels->at(3, 3)] / 16.0, 255 * light_now / (1 + light_now), 1);
}

double pattern(double x, double y) {
  return 120 + 50 * std::sin(x / 2.1) * std::cos(y / 2.7) + 20 * std::sin(x / 9 + y / 7);
}

/// The image of a plane with a pattern, pixel by pixel along its lines of sight.
std::vector<std::uint8_t> image_of_plane(const CameraModel& camera, const RigidTransform& pose, const Vec2& slope) {
  std::vector<std::uint8_t> image;
  const RigidTransform back = inverse(pose);
  for (std::int32_t v = 0; v < camera.height; ++v) {
    for (std::int32_t u = 0; u < camera.width; ++u) {
      const Vec2 n = normalised_from_pixel(camera, Vec2(u, v));
      const Vec3 d = back.rotation * Vec3(n.x(), n.y(), 1), c = back.translation;
      const double t = (slope.dot(c.head<2>()) - c.z()) / (d.z() - slope.dot(d.head<2>()));
      image.push_back(static_cast<std::uint8_t>(std::lround(pattern(c.x() + t * d.x(), c.y() + t * d.y()))));
    }
  }
  return image;
}

TEST(KeyframeSheet, ShowsTheGroundThroughAnyLens) {
  CameraModel brown = camera_of_field(320, 240, 1.0);
  brown.k1 = -0.12;
  brown.k2 = 0.03;
  brown.p1 = 0.002;
  CameraModel fisheye = camera_of_field(320, 240, 1.2);
  fisheye.lens = Lens::fisheye;
  fisheye.k1 = -0.02;
  Rng rng(9);
  for (const CameraModel& camera : {brown, fisheye}) {
    ASSERT_TRUE(validate(camera).ok());
    RigidTransform pose;
    pose.rotation = rotation_from_vector(Vec3(0.1, -0.05, 0)) * rotation_from_vector(Vec3(0, 0, 0.6)) *
                    Vec3(1, -1, -1).asDiagonal();
    pose.translation = -(pose.rotation * Vec3(3, -2, 60));
    const Vec2 slope(0.1, -0.05);
    const std::vector<std::uint8_t> image = image_of_plane(camera, pose, slope);
    const PlaneWindow plane(120, 110, 1, slope.x(), slope.y());
    MapPlan plan;
    plan.search_px = plan.sheet_column = plan.sheet_row = 20;
    plan.pixel_m = 1;
    plan.first_column = -60;
    plan.first_row = -55;
    plan.sheet_width = 80;
    plan.sheet_height = 70;
    std::vector<std::int32_t> sum(80 * 70, 0);
    std::vector<std::uint8_t> count(80 * 70, 0);
    const SheetSums sums{80, 70, sum.data(), count.data()};
    SheetPainter painter;
    ASSERT_TRUE(painter.begin({GrayView(image.data(), 320, 240), camera, pose}, plan, plane.window, 0).ok());
    painter.paint_rows(plane.window, 0, 70, sums);
    // Greys are less the mean of the image: the same for all.
    double offset = 0;
    int cells = 0;
    std::vector<double> differences;
    for (std::int32_t row = 0; row < 70; ++row) {
      for (std::int32_t column = 0; column < 80; ++column) {
        const auto k = static_cast<std::size_t>(row * 80 + column);
        if (count[k] == 0) continue;
        const double x = plane.window.x0_m + column + 20.5, y = plane.window.y0_m - row - 20.5;
        differences.push_back(sum[k] / 16.0 - pattern(x, y));
        offset += differences.back();
        ++cells;
      }
    }
    ASSERT_GT(cells, 1500);
    offset /= cells;
    double squares = 0;
    for (const double difference : differences) squares += (difference - offset) * (difference - offset);
    EXPECT_LT(std::sqrt(squares / cells), 2.0) << "of a pattern with a deviation of 28";
  }
}

TEST(KeyframeSheet, ShadowsAndTheirEdgesAreNotCompared) {
  // Level ground in the sun, of which a part lies in the light of the sky alone.
  constexpr std::int32_t side = 24, first_dark = 8, last_dark = 11;
  constexpr std::uint8_t lit = 128, dark = 51;
  const auto sheet = std::make_unique<MapChannels<max_map_sheet_side>>();
  sheet->width = sheet->height = side;
  std::vector<std::uint8_t> image(static_cast<std::size_t>(320) * 240, lit);
  const CameraModel camera = camera_of_field(320, 240, 1.0);
  RigidTransform pose;
  pose.rotation = Vec3(1, -1, -1).asDiagonal();
  pose.translation = Vec3(0, 0, 60);
  SheetPainter painter;
  const PlaneWindow plane(60, 60, 1, 0, 0);
  MapPlan plan;
  plan.pixel_m = 1;
  ASSERT_TRUE(painter.begin({GrayView(image.data(), 320, 240), camera, pose}, plan, plane.window, 0).ok());
  for (std::int32_t row = 0; row < side; ++row) {
    for (std::int32_t column = 0; column < side; ++column) {
      const bool shadow = column >= first_dark && column <= last_dark;
      sheet->value[sheet->at(column, row)] = static_cast<std::int16_t>(16 * (shadow ? dark - lit : column % 3));
    }
  }
  fill_directions(*sheet, 1, 0, side);
  const auto before = std::make_unique<MapChannels<max_map_sheet_side>>(*sheet);
  hide_dark_cells(painter.darkest_lit(), *sheet);
  for (std::int32_t column = 0; column < side; ++column) {
    const std::size_t at = sheet->at(column, side / 2);
    const bool hidden = column >= first_dark - 1 && column <= last_dark + 1;
    EXPECT_EQ(sheet->value[at] == unknown_value, column >= first_dark && column <= last_dark) << column;
    EXPECT_EQ(sheet->direction[2 * at], hidden ? 0 : before->direction[2 * at]) << column;
  }
  EXPECT_GT(std::abs(before->direction[2 * sheet->at(first_dark - 1, side / 2)]), 100) << "the edge of the shadow";
}

TEST(MapPlan, HoldsTheGroundAndSaysWhatItCannot) {
  Rng rng(10);
  const CameraModel camera = camera_of_field(640, 480, 1.05);
  MapPrior prior;
  prior.camera_from_map.rotation = Vec3(1, -1, -1).asDiagonal();
  prior.camera_from_map.translation = -(prior.camera_from_map.rotation * Vec3(1000, -700, 100));
  for (int k = 0; k < 6; ++k) prior.covariance(k, k) = k < 3 ? 1e-4 : 25;
  const MapKeyframe keyframe{{}, camera, prior.camera_from_map};
  const std::span<const MapKeyframe> keyframes(&keyframe, 1);
  const double image_m = image_pixel_m(camera, prior.camera_from_map, 0);
  EXPECT_NEAR(image_m, 100 / camera.fx, 1e-9);
  const double pixel = map_working_pixel_m(camera, image_m, 0.25);
  EXPECT_GE(pixel, 4.5 * image_m);
  EXPECT_EQ(map_working_pixel_m(camera, image_m, 6), 6);

  const Result<MapPlan> planned = plan_map_window(keyframes, prior, 0, pixel);
  ASSERT_TRUE(planned.ok());
  const MapPlan& plan = planned.value();
  EXPECT_EQ(plan.patch_px, 16);
  EXPECT_EQ(plan.search_px, std::max(16, static_cast<int>(std::ceil(3 * std::sqrt(25 + 1.0) / pixel))) + map_edge_px);
  const double half_width = 320 * image_m, half_height = 240 * image_m, search = plan.search_px * pixel;
  EXPECT_LE(plan.x0_m() + search, 1000 - half_width);
  EXPECT_GE(plan.x0_m() + (plan.width - plan.search_px) * pixel, 1000 + half_width);
  EXPECT_GE(plan.y0_m() - search, -700 + half_height);
  EXPECT_LE(plan.y0_m() - (plan.height - plan.search_px) * pixel, -700 - half_height);

  for (int k = 3; k < 6; ++k) prior.covariance(k, k) = 40 * 40;
  const Result<MapPlan> wide = plan_map_window(keyframes, prior, 0, pixel);
  EXPECT_TRUE(wide.status().is(StatusCode::capacity_exceeded));
  EXPECT_GT(wide.status().a, most_map_search_px);
  EXPECT_TRUE(plan_map_window(keyframes, prior, 200, pixel).status().is(StatusCode::not_found));
  EXPECT_TRUE(plan_map_window(keyframes, prior, 0, -1).status().is(StatusCode::invalid_argument));
  EXPECT_TRUE(plan_map_window({}, prior, 0, pixel).status().is(StatusCode::invalid_argument));
}

TEST(MapRegistration, RefusesWhatItCannotReadAndAnswersWhereThereIsNothing) {
  const CameraModel camera = camera_of_field(320, 240, 1.0);
  std::vector<std::uint8_t> grey(320 * 240, 90);
  MapPrior prior;
  prior.camera_from_map.rotation = Vec3(1, -1, -1).asDiagonal();
  prior.camera_from_map.translation = -(prior.camera_from_map.rotation * Vec3(0, 0, 60));
  for (int k = 0; k < 6; ++k) prior.covariance(k, k) = k < 3 ? 1e-4 : 4;
  MapKeyframe keyframe{GrayView(grey.data(), 320, 240), camera, prior.camera_from_map};
  const MapPlan plan = plan_map_window({&keyframe, 1}, prior, 0, 1).value();
  PlaneWindow plane(plan.width, plan.height, 1, 0.01, 0);
  plane.window.x0_m = plan.x0_m();
  plane.window.y0_m = plan.y0_m();
  MapRegistrationInput input{plan, plane.window, prior, {&keyframe, 1}, {1, 1}, nullptr};
  const auto workspace = std::make_unique<MapRegistrationWorkspace>();
  const auto registration = std::make_unique<MapRegistration>();
  const auto verdict = [&] {
    EXPECT_TRUE(registration->begin(input, {}, *workspace).ok());
    for (int k = 0; k < 10000 && registration->step().value(); ++k) {
    }
    return registration->result().verdict;
  };
  const auto refused = [&](const MapRegistrationInput& wrong) {
    return !registration->begin(wrong, {}, *workspace).ok() && registration->done();
  };

  EXPECT_EQ(verdict(), MapVerdict::no_texture) << "an even image";
  Rng rng(11);
  for (std::uint8_t& value : grey) value = static_cast<std::uint8_t>(rng.below(256));
  EXPECT_EQ(verdict(), MapVerdict::no_map) << "an image of noise over even ground";
  std::fill(plane.known.begin(), plane.known.end(), std::uint8_t{0});
  std::fill(plane.image.begin(), plane.image.end(), std::uint8_t{0});
  EXPECT_EQ(verdict(), MapVerdict::no_map) << "a map that knows nothing";

  MapRegistrationInput wrong = input;
  wrong.window.width -= 1;
  EXPECT_TRUE(refused(wrong));
  wrong = input;
  wrong.plan.search_px = 50;
  EXPECT_TRUE(refused(wrong));
  wrong = input;
  wrong.window.pixel_m = std::nan("");
  EXPECT_TRUE(refused(wrong));
  wrong = input;
  wrong.keyframes = {};
  EXPECT_TRUE(refused(wrong));
  wrong = input;
  wrong.prior.covariance(2, 2) = std::nan("");
  EXPECT_TRUE(refused(wrong));
  plane.height[77] = std::nanf("");
  EXPECT_TRUE(refused(input));
  plane.height[77] = 0;
  keyframe.image = GrayView(grey.data(), 300, 240);
  EXPECT_TRUE(refused(input));
}

/// Smooth ground of standard deviation 2 m that repeats itself after this way, px; what is added to each cell does not.
MapWindow repeating_window(std::int32_t side, std::int32_t columns, std::int32_t rows, double error_m, Rng& rng,
                           WindowStore& store) {
  std::vector<double> noise(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows)), smooth(noise.size());
  for (double& value : noise) value = normal(rng);
  const auto cell = [&](std::int32_t x, std::int32_t y) {
    return static_cast<std::size_t>((y + 4 * rows) % rows * columns + (x + 4 * columns) % columns);
  };
  for (std::int32_t y = 0; y < rows; ++y) {
    for (std::int32_t x = 0; x < columns; ++x) {
      for (std::int32_t k = 0; k < 25; ++k) smooth[cell(x, y)] += 0.4 * noise[cell(x + k % 5 - 2, y + k / 5 - 2)];
    }
  }
  const auto cells = static_cast<std::size_t>(side * side);
  store.known.assign(cells, 1);
  store.height_m.clear();
  for (std::int32_t k = 0; k < side * side; ++k) {
    store.height_m.push_back(static_cast<float>(smooth[cell(k % side, k / side)] + error_m * normal(rng)));
  }
  MapWindow window;
  window.width = window.height = side;
  window.pixel_m = 1;
  window.height_m = store.height_m.data();
  window.known = store.known.data();
  return window;
}

bool ground_repeats(const MapWindow& window, std::int32_t sheet_side) {
  const auto workspace = std::make_unique<MapRegistrationWorkspace>();
  MapPlan plan;
  plan.sheet_column = plan.sheet_row = 20;
  workspace->sheet.width = workspace->sheet.height = sheet_side;
  RepeatSearch search;
  search.begin(window, 0, plan, *workspace);
  while (search.step(*workspace)) {
  }
  return search.repeats();
}

TEST(MapRepeats, GroundThatRepeatsItselfWithinTheImageIsTold) {
  Rng rng(12);
  WindowStore store;
  // Sheets as small as those of relief, and as large as those of light, whose heights are reduced.
  for (const std::int32_t side : {40, 56, 140}) {
    const std::int32_t window_side = side + 40;
    const std::int32_t far = 2 * side / 3, near = side / 2;
    for (const auto& [columns, rows] : {std::pair(far, 500), std::pair(500, far), std::pair(near, near + 3)}) {
      EXPECT_TRUE(ground_repeats(repeating_window(window_side, columns, rows, 0.2, rng, store), side))
          << side << ": " << columns << " x " << rows;
    }
    for (int trial = 0; trial < 10; ++trial) {
      EXPECT_FALSE(ground_repeats(repeating_window(window_side, 500, 500, 0.2, rng, store), side)) << side;
    }
  }
}

TEST(MapRepeats, LevelGroundAndHolesRepeatNothing) {
  Rng rng(13);
  WindowStore store;
  MapWindow window = repeating_window(90, 30, 30, 0, rng, store);
  EXPECT_TRUE(ground_repeats(window, 50));
  std::fill(store.height_m.begin(), store.height_m.end(), 3.0F);
  EXPECT_FALSE(ground_repeats(window, 50));
  std::fill(store.known.begin(), store.known.end(), std::uint8_t{0});
  EXPECT_FALSE(ground_repeats(window, 50));
}

}  // namespace
}  // namespace ilp::test
