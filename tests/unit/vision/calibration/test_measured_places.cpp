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
    return place_equations(cameras, places, loss, *out) ? std::move(out) : nullptr;
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
