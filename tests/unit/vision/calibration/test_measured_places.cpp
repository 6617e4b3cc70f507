// Equations of measured places, against similarities and differences of their own cost.
#include "fsw/vision/calibration/measured_places.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "fsw/vision/geometry/similarity.hpp"

namespace ilp::test {
namespace {

constexpr double no_loss = 1e6;  // sigmas: plain least squares
constexpr std::size_t views = 6;

struct Flown {
  std::vector<RigidTransform> cameras;
  MeasuredPlaces places;
  HeightsInWindow heights;

  /// `straight`: on a line, where the turn about it is open.
  explicit Flown(unsigned seed, bool straight = false) : random(seed) {
    std::normal_distribution<double> normal(0, 1);
    const auto any = [&] { return Vec3(normal(random), normal(random), normal(random)); };
    Similarity world;
    world.rotation = rotation_from_vector(any());
    world.scale = 30;
    world.translation = 1000 * any();
    for (std::size_t i = 0; i < views; ++i) {
      const double t = static_cast<double>(i);
      const Vec3 centre = straight ? Vec3(t, 2 * t, 0.5 * t) : Vec3(t, std::sin(t), 0.3 * std::cos(2 * t));
      const Mat3 turn = rotation_from_vector(0.2 * any());
      cameras.push_back({turn, -(turn * centre)});
      const Vec3 at = world * centre;
      (void)places.push_back({static_cast<std::uint16_t>(i), {at.x(), at.y(), at.z()}, {0.5, 0.5, 2}});
    }
  }
  void move(std::size_t view, const Vec3& by) { cameras[view].translation -= cameras[view].rotation * by; }
  void disturb(double sigmas) {
    std::normal_distribution<double> normal(0, sigmas);
    for (MeasuredPlace& place : places) {
      for (int k = 0; k < 3; ++k) place.place_m[k] += place.sigma_m[k] * normal(random);
    }
  }
  [[nodiscard]] std::unique_ptr<PlaceEquations> equations(double loss = no_loss) const {
    auto out = std::make_unique<PlaceEquations>();
    return place_equations(cameras, places, heights, loss, *out) ? std::move(out) : nullptr;
  }

  std::mt19937 random;
};

TEST(MeasuredPlacesTest, PlacesThatFitAskForNothingAndASimilarityCostsNothing) {
  for (const bool straight : {false, true}) {
    const Flown flown(3, straight);
    const auto found = flown.equations();
    ASSERT_TRUE(found) << straight;
    EXPECT_LT(found->squared, 1e-12);
    using Vector = Eigen::Matrix<double, PlaceEquations::size, 1>;
    const Eigen::Map<const Eigen::Matrix<double, PlaceEquations::size, PlaceEquations::size, Eigen::RowMajor>> h(
        &found->information[0][0]);
    // The turn that a straight track leaves open is held by a billionth.
    EXPECT_LT((h - h.transpose()).norm(), 1e-6 * h.norm());
    for (int kind = 0; kind < 7; ++kind) {
      Vector moved = Vector::Zero();
      for (std::size_t i = 0; i < views; ++i) {
        const Vec3 centre = -(flown.cameras[i].rotation.transpose() * flown.cameras[i].translation);
        moved.segment<3>(static_cast<int>(3 * i)) = change_by_step(centre).col(kind);
      }
      EXPECT_LT((h * moved).norm(), 1e-6 * h.norm() * moved.norm()) << straight << " " << kind;
    }
  }
}

TEST(MeasuredPlacesTest, TheEquationsAreTheDerivativesOfWhatTheSimilarityLeaves) {
  Flown flown(4);
  flown.disturb(0.5);
  const auto found = flown.equations();
  ASSERT_TRUE(found);
  EXPECT_GT(found->squared, 0.5);
  constexpr double step = 1e-4;
  for (std::size_t i = 0; i < 3 * views; ++i) {
    Vec3 by = Vec3::Zero();
    by[static_cast<int>(i % 3)] = step;
    Flown more = flown, less = flown;
    more.move(i / 3, by);
    less.move(i / 3, -by);
    const double slope = (more.equations()->squared - less.equations()->squared) / (4 * step);
    EXPECT_NEAR(found->gradient[i], slope, 1e-3 * (1 + std::abs(slope))) << i;
    const double bend =
        (more.equations()->squared + less.equations()->squared - 2 * found->squared) / (2 * step * step);
    // Gauss-Newton leaves out what the residuals times the curvature add.
    EXPECT_NEAR(found->information[i][i], bend, 0.05 * bend) << i;
  }
}

/// With the distances of level ground 8 units below the first centre, whose heights are 30 m a unit.
Flown flown_above_ground(unsigned seed, double wrong_by = 1) {
  Flown flown(seed);
  for (std::size_t i = 0; i < views; ++i) {
    const double distance = 8 + 0.2 * static_cast<double>(i);
    (void)flown.heights.push_back({distance, 0.01, wrong_by * 30 * distance, 1.5});
  }
  return flown;
}

TEST(MeasuredPlacesTest, DistancesFromTheGroundCountInTheScaleOfThePlaces) {
  Flown flown = flown_above_ground(14);
  EXPECT_LT(flown.equations()->squared, 1e-12);
  flown.disturb(0.5);
  for (HeightInWindow& height : flown.heights) height.height_m += 1;
  const auto found = flown.equations();
  ASSERT_TRUE(found);
  constexpr double step = 1e-4;
  for (std::size_t i = 0; i < views; ++i) {
    Flown more = flown, less = flown;
    more.heights[i].distance += step;
    less.heights[i].distance -= step;
    const double slope = (more.equations()->squared - less.equations()->squared) / (4 * step);
    const std::size_t row = PlaceEquations::centre_rows + i;
    EXPECT_NEAR(found->gradient[row], slope, 1e-3 * (1 + std::abs(slope))) << i;
    const double bend =
        (more.equations()->squared + less.equations()->squared - 2 * found->squared) / (2 * step * step);
    EXPECT_NEAR(found->information[row][row], bend, 0.05 * bend) << i;
    // What a distance shares with a centre.
    for (std::size_t k = 0; k < 3 * views; ++k) {
      Vec3 by = Vec3::Zero();
      by[static_cast<int>(k % 3)] = step;
      Flown both = more, against = more, neither = less, other = less;
      both.move(k / 3, by);
      against.move(k / 3, -by);
      other.move(k / 3, by);
      neither.move(k / 3, -by);
      const double shared = (both.equations()->squared - against.equations()->squared - other.equations()->squared +
                             neither.equations()->squared) /
                            (8 * step * step);
      EXPECT_NEAR(found->information[row][k], shared, 0.02 * bend) << i << " " << k;
    }
  }
}

TEST(MeasuredPlacesTest, ACommonStretchOfCentresAndDistancesCostsNothing) {
  Flown flown = flown_above_ground(15);
  flown.disturb(0.5);
  const auto before = flown.equations();
  for (RigidTransform& camera : flown.cameras) camera.translation *= 1.1;
  for (HeightInWindow& height : flown.heights) height.distance *= 1.1, height.sigma *= 1.1;
  EXPECT_NEAR(flown.equations()->squared, before->squared, 1e-6 * before->squared);
  for (HeightInWindow& height : flown.heights) height.distance *= 1.1;
  EXPECT_GT(flown.equations()->squared, 10 * before->squared) << "of the distances alone it does";
}

TEST(MeasuredPlacesTest, HeightsThatNoLensExplainsAddNothing) {
  const auto with = flown_above_ground(16, 2).equations(5), without = Flown(16).equations(5);
  ASSERT_TRUE(with && without);
  EXPECT_EQ(with->squared, without->squared);
  for (std::size_t i = PlaceEquations::centre_rows; i < PlaceEquations::size; ++i) EXPECT_EQ(with->gradient[i], 0);
}

TEST(MeasuredPlacesTest, NothingPullsAtWhatTheSimilarityLeavesOpen) {
  Flown flown(8);
  flown.disturb(1);
  const auto found = flown.equations(2);
  ASSERT_TRUE(found);
  using Vector = Eigen::Matrix<double, PlaceEquations::size, 1>;
  const Eigen::Map<const Vector> gradient(found->gradient);
  for (int kind = 0; kind < 7; ++kind) {
    Vector moved = Vector::Zero();
    for (std::size_t i = 0; i < views; ++i) {
      const Vec3 centre = -(flown.cameras[i].rotation.transpose() * flown.cameras[i].translation);
      moved.segment<3>(static_cast<int>(3 * i)) = change_by_step(centre).col(kind);
    }
    EXPECT_LT(std::abs(gradient.dot(moved)), 1e-7 * gradient.norm() * moved.norm()) << kind;
  }
}

TEST(MeasuredPlacesTest, WhatNoLensExplainsOrIsTooLittleSaysNothing) {
  Flown flown(5);
  flown.places[2].place_m[0] += 200;
  EXPECT_FALSE(flown.equations(5));
  Flown few(6);
  (void)few.places.resize(2);
  EXPECT_FALSE(few.equations());
  Flown still(7);
  for (MeasuredPlace& place : still.places) std::fill_n(place.place_m, 3, 1.0);
  EXPECT_FALSE(still.equations());
}

}  // namespace
}  // namespace ilp::test
