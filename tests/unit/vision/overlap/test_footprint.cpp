#include <gtest/gtest.h>

#include <cmath>

#include "fsw/base/math.hpp"
#include "fsw/vision/overlap/overlap.hpp"

namespace ilp {
namespace {

constexpr std::int32_t width = 640, height = 480;

// The similarity that turns and scales about the image centre, then shifts.
Similarity2 about_centre(double scale, double rotation_rad, double shift_x, double shift_y) {
  const double cx = 0.5 * (width - 1), cy = 0.5 * (height - 1);
  const double c = scale * det_cos(rotation_rad), s = scale * det_sin(rotation_rad);
  return {scale, rotation_rad, cx - c * cx + s * cy + shift_x, cy - s * cx - c * cy + shift_y};
}

TEST(Footprint, ShiftLeavesTheProductOfTheSides) {
  EXPECT_NEAR(footprint_overlap(width, height, {}), 1.0, 1e-12);
  EXPECT_NEAR(footprint_overlap(width, height, {1, 0, 160, -120}), 0.75 * 0.75, 1e-12);
  EXPECT_NEAR(footprint_overlap(width, height, {1, 0, -64, 0}), 0.9, 1e-12);
  EXPECT_EQ(footprint_overlap(width, height, {1, 0, 641, 0}), 0.0);
}

TEST(Footprint, QuarterTurnLeavesTheCommonSquare) {
  EXPECT_NEAR(footprint_overlap(width, height, about_centre(1, pi / 2, 0, 0)), 480.0 / 640.0, 1e-9);
}

TEST(Footprint, ScaleCountsInTheAreaOfTheFirstImage) {
  EXPECT_NEAR(footprint_overlap(width, height, about_centre(2, 0, 0, 0)), 0.25, 1e-9);
  EXPECT_NEAR(footprint_overlap(width, height, about_centre(0.5, 0, 0, 0)), 1.0, 1e-9);
  EXPECT_NEAR(footprint_overlap(width, height, about_centre(0.5, 0.3, 320, 0)), 0.5, 0.01);
}

TEST(Footprint, TurnedSquaresMeetInAnOctagon) {
  // Two unit squares turned by 45 degrees meet in a regular octagon of area 2 (sqrt 2 - 1).
  const double c = 0.5 * (480 - 1), k = 0.70710678118654752440;
  const Similarity2 turn{1, pi / 4, c, c - 2 * k * c};
  EXPECT_NEAR(footprint_overlap(480, 480, turn), 2 * (1.41421356237309504880 - 1), 1e-9);
}

TEST(Footprint, HomographyIgnoresWhatLiesBehindTheHorizon) {
  // The ground behind the vanishing line maps into b's frame by sign only; it must not count.
  const double h[9] = {1, 0, 0, 0, 1, 0, -1.0 / 320, 0, 1};
  const double overlap = footprint_overlap_of_plane(width, height, h);
  // x / (1 - x/320) <= 639.5 holds for x <= 213.2; y / (1 - x/320) <= 479.5 cuts a corner of that.
  EXPECT_GT(overlap, 0.15);
  EXPECT_LT(overlap, 0.334);
}

TEST(Footprint, TheViewTurnsWhereDistancesOfTheCornersChangeByDifferentFactors) {
  // A camera that looks straight at the plane goes about its middle by an angle, at the same distance: H = R + t n'.
  for (const double angle : {0.0, 0.1, 0.4}) {
    const double f = 500, c = std::cos(angle), s = std::sin(angle);
    const double cx = 0.5 * (width - 1), cy = 0.5 * (height - 1);
    // x' = f c x / (f - s x), y' = f y / (f - s x), about the middle.
    const double about_middle[9] = {f * c, 0, 0, 0, f, 0, -s, 0, f};
    const double to_middle[9] = {1, 0, -cx, 0, 1, -cy, 0, 0, 1}, from_middle[9] = {1, 0, cx, 0, 1, cy, 0, 0, 1};
    double plane[9];
    compose_planes(about_middle, to_middle, plane);
    compose_planes(from_middle, plane, plane);
    EXPECT_NEAR(view_turn_of_plane(width, height, plane), (f + s * cx) / (f - s * cx), 1e-9) << angle;
  }
  const double climb[9] = {0.7, 0.1, 30, -0.1, 0.7, 20, 0, 0, 1};
  EXPECT_DOUBLE_EQ(view_turn_of_plane(width, height, climb), 1);
  const double edge_on[9] = {1, 0, 0, 0, 1, 0, -1.0 / 320, 0, 1};
  EXPECT_EQ(view_turn_of_plane(width, height, edge_on), HUGE_VAL);
}

TEST(Footprint, GroundOfThreeImagesIsWhatBothHomographiesKeep) {
  const double right[9] = {1, 0, -160, 0, 1, 0, 0, 0, 1}, down[9] = {1, 0, 0, 0, 1, -120, 0, 0, 1};
  const double back[9] = {1, 0, 400, 0, 1, 0, 0, 0, 1};
  EXPECT_NEAR(footprint_shared_by_three(width, height, right, down), 0.75 * 0.75, 1e-12);
  EXPECT_NEAR(footprint_shared_by_three(width, height, right, right), 0.5, 1e-12);
  // The third image shows the columns up to 400 of the first one; the second one those from 160 on.
  EXPECT_NEAR(footprint_shared_by_three(width, height, right, back), 0.375, 1e-12);
}

}  // namespace
}  // namespace ilp
