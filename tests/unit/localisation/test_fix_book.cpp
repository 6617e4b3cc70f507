// What the latest fixes of a strip lead to, against errors that are drawn as the fixes state them.
#include <gtest/gtest.h>

#include <cmath>

#include "fsw/base/math.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/localisation/fix_book.hpp"

namespace ilp::test {
namespace {

constexpr double ground_sigma_m = 0.5, distance_m = 100;

double normal(Rng& rng) {
  const double u = std::max(rng.uniform(), 1e-12);
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * pi * rng.uniform());
}

/// Cameras that look straight down on a straight way. Of the variance of their ground a share is one error of all.
FixBook book_of(double shared, double stated, Rng& rng) {
  FixBook book;
  const double east = normal(rng), north = normal(rng);
  for (int i = 0; i < static_cast<int>(kept_fixes); ++i) {
    navigation::MeasuredKeyframe k{.keyframe_id = i + 1};
    k.centre[0] = 20.0 * i;
    k.centre[2] = distance_m;
    k.q_cam_from_strip[0] = k.fix.q_cam_from_level[0] = 0;  // half a turn about x
    k.q_cam_from_strip[1] = k.fix.q_cam_from_level[1] = 1;
    k.fix.tilt_sigma_rad = k.fix.heading_sigma_rad = 1e-4;
    const double own = ground_sigma_m * std::sqrt(1 - shared), common = ground_sigma_m * std::sqrt(shared);
    k.fix.ground_m[0] = k.centre[0] + own * normal(rng) + common * east;
    k.fix.ground_m[1] = own * normal(rng) + common * north;
    for (double& sigma : k.fix.ground_sigma_m) sigma = ground_sigma_m;
    k.fix.distance_m = k.fix.depth = distance_m;
    k.fix.distance_sigma_m = k.fix.depth_sigma = 0.1;
    k.fix.shared = stated;
    EXPECT_TRUE(book.fixes.push_back(k));
  }
  return book;
}

/// Squared error of the middle of the fixes' ground over its variance, mean of many books.
double normalised_error(double shared, double stated) {
  Rng rng(3);
  static navigation::MeasuredKeyframes scratch;
  constexpr int trials = 400;
  double sum = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const navigation::StripFrame frame = frame_by_fixes(book_of(shared, stated, rng), scratch);
    EXPECT_GT(frame.fixed_sigma_m[0], 0);
    const double x = frame.fixed_place_m.x() - 10.0 * (kept_fixes - 1), y = frame.fixed_place_m.y();
    sum += 0.5 * (x * x / (frame.fixed_sigma_m[0] * frame.fixed_sigma_m[0]) +
                  y * y / (frame.fixed_sigma_m[1] * frame.fixed_sigma_m[1]));
  }
  return sum / trials;
}

TEST(FixBookTest, AMeanOfFixesKeepsTheErrorThatTheyShare) {
  EXPECT_NEAR(normalised_error(0, 0), 0.9, 0.3);
  EXPECT_NEAR(normalised_error(0.25, 0.25), 0.9, 0.3);
  // The test can tell.
  EXPECT_GT(normalised_error(0.25, 0), 1.8);
}

}  // namespace
}  // namespace ilp::test
