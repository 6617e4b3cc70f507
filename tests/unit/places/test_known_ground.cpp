// Known cells over a plane, where the answer follows from the geometry.
#include "fsw/places/known_ground.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "fsw/vision/geometry/camera.hpp"

namespace ilp {
namespace {

constexpr double distance = 100;

class KnownGroundTest : public testing::Test {
 protected:
  KnownGroundTest() {
    camera_.width = 320;
    camera_.height = 240;
    camera_.fx = camera_.fy = 320;
    camera_.cx = 159.5;
    camera_.cy = 119.5;
    fill(*seen_, distance);
    fill(*other_, distance);
    depths_->fill(static_cast<float>(1 / distance));
    known_->fill(0);
    mask_.assign(static_cast<std::size_t>(camera_.width * camera_.height), 255);
  }
  void fill(SeenCells& cells, double from) const {
    ASSERT_TRUE(clear_seen_cells(camera_.width, camera_.height, cells).ok());
    cells.quality.fill(seen_quality(from / camera_.fx, 0.002));
  }
  /// The other camera stands `x` to the right, as high.
  static Similarity to_the_right(double x) { return {Mat3::Identity(), Vec3(-x, 0, 0), 1}; }
  void mark(const Similarity& other_from_camera, double error_px = 0) {
    mark_known({mask(), *seen_, *depths_, camera_}, {*other_, other_from_camera, error_px}, 1.8, *known_);
  }
  /// All ground is known, but for what `is_new` says.
  template <typename IsNew>
  void know_all_but(IsNew is_new) {
    known_->fill(0);
    for (int y = 0; y < camera_.height; ++y) {
      for (int x = 0; x < camera_.width; ++x) {
        const auto cell = static_cast<std::size_t>(y / 8 * seen_->columns + x / 8);
        if (!is_new(x, y)) (*known_)[cell] |= std::uint64_t{1} << static_cast<unsigned>(y % 8 * 8 + x % 8);
      }
    }
  }
  [[nodiscard]] MaskView mask() const { return {mask_.data(), camera_.width, camera_.height}; }
  std::uint32_t take() {
    const ImageView<std::uint8_t> pixels(mask_.data(), camera_.width, camera_.height);
    std::uint32_t count = 0;
    for (std::size_t part = 0; take_known_slice(*known_, 4, 2, pixels, part, count);) ++part;
    return count;
  }
  [[nodiscard]] bool taken(int x, int y) const { return mask_[static_cast<std::size_t>(y * camera_.width + x)] == 0; }

  CameraModel camera_;
  std::unique_ptr<SeenCells> seen_ = std::make_unique<SeenCells>();
  std::unique_ptr<SeenCells> other_ = std::make_unique<SeenCells>();
  std::unique_ptr<CellDepths> depths_ = std::make_unique<CellDepths>();
  std::unique_ptr<KnownGround> known_ = std::make_unique<KnownGround>();
  std::vector<std::uint8_t> mask_;
};

// A shift by 50 is 160 px: half the image.
TEST_F(KnownGroundTest, TheCommonPartIsTakenButForItsBorder) {
  mark(to_the_right(50));
  EXPECT_GT(take(), 0U);
  for (int y = 4; y < camera_.height; y += 8) {
    EXPECT_FALSE(taken(159, y));
    EXPECT_FALSE(taken(161, y)) << "the border";
    EXPECT_TRUE(taken(163, y));
    EXPECT_TRUE(taken(319, y));
  }
}

TEST_F(KnownGroundTest, TheSameGroundInAnotherUnitIsKnown) {
  fill(*other_, 7 * distance);
  mark({Mat3::Identity(), Vec3::Zero(), 7});
  EXPECT_EQ(take(), mask_.size());
}

TEST_F(KnownGroundTest, AViewThatIsMuchFinerClaimsTheGround) {
  fill(*other_, 2 * distance);
  mark({Mat3::Identity(), Vec3(0, 0, distance), 1});
  EXPECT_EQ(take(), 0U);
}

// Whatever the unit of the other strip, and wherever the distances lie between the levels of the qualities.
TEST_F(KnownGroundTest, GroundIsClaimedExactlyFromTheRatioOn) {
  for (const double unit : {1.0, 3.258, 0.31}) {
    for (const double from : {100.0, 107.0, 115.0, 123.0}) {
      for (const double finer : {1.1, 1.42, 1.6, 1.69, 1.79, 1.81, 2.1}) {
        fill(*seen_, from);
        fill(*other_, finer * from * unit);
        depths_->fill(static_cast<float>(1 / from));
        known_->fill(0);
        mask_.assign(mask_.size(), 255);
        mark({Mat3::Identity(), Vec3(0, 0, (finer - 1) * from * unit), unit});
        EXPECT_EQ(take(), finer < 1.8 ? mask_.size() : 0) << unit << ", " << from << ", " << finer;
      }
    }
  }
}

TEST_F(KnownGroundTest, GroundInACellWithFewDepthsIsKnownByThoseBesideIt) {
  for (std::int32_t row = 0; row < seen_->rows; ++row) {
    const auto cell = static_cast<std::size_t>(row * seen_->columns);
    seen_->quality[cell] = 0;
    (*depths_)[cell] = 0;
  }
  mark({Mat3::Identity(), Vec3::Zero(), 1});
  EXPECT_EQ(take(), mask_.size());
}

// The other view ends in the middle of this one, and may end 6 px further.
TEST_F(KnownGroundTest, WhatMayLieOutsideTheOtherViewIsNotKnown) {
  mark(to_the_right(50), 6);
  take();
  EXPECT_FALSE(taken(160 + 6, 100));
  EXPECT_TRUE(taken(160 + 6 + 3, 100));
  EXPECT_FALSE(taken(200, 5)) << "the upper border";
  EXPECT_TRUE(taken(200, 9));
}

TEST_F(KnownGroundTest, SliversBetweenKnownGroundAreTakenAndWhatIsWiderIsNot) {
  know_all_but([](int x, int y) { return (x >= 100 && x < 103) || (x >= 200 && x < 204) || (y == 50 && x < 90); });
  take();
  for (int y = 60; y < 200; ++y) EXPECT_TRUE(taken(101, y));
  EXPECT_TRUE(taken(50, 50));
  for (int y = 0; y < 240; ++y) {
    for (int x = 198; x < 206; ++x) EXPECT_FALSE(taken(x, y)) << "four pixels and the border of two";
  }
}

TEST_F(KnownGroundTest, ThinGroundFarFromKnownGroundStays) {
  know_all_but([](int x, int) { return x < 200; });
  for (int y = 0; y < camera_.height; ++y) {
    for (int x = 0; x < 150; ++x) mask_[static_cast<std::size_t>(y * camera_.width + x)] = y == 70 ? 255 : 0;
  }
  take();
  for (int x = 0; x < 150; ++x) EXPECT_FALSE(taken(x, 70));
}

TEST_F(KnownGroundTest, ARestOfLessThanFourCellsIsTakenAndASmallMaskWithoutKnownGroundIsNot) {
  const auto square = [](int side) { return [side](int x, int y) { return x / side == 3 && y / side == 3; }; };
  know_all_but(square(13));
  EXPECT_EQ(take(), mask_.size() - 13 * 13 - 4 * 2 * 13) << "with the border at its four sides";
  mask_.assign(mask_.size(), 255);
  know_all_but(square(12));
  EXPECT_EQ(take(), mask_.size()) << "240 pixels with the border";
  known_->fill(0);
  mask_.assign(mask_.size(), 0);
  mask_[1000] = 255;
  EXPECT_EQ(take(), 0U);
  EXPECT_EQ(mask_[1000], 255);
}

TEST_F(KnownGroundTest, GroundThatTheOtherHasNotReconstructedStaysNew) {
  for (std::int32_t row = 0; row < other_->rows; ++row) {
    for (std::int32_t column = 0; column < 20; ++column) {
      other_->quality[static_cast<std::size_t>(row * other_->columns + column)] = 0;
    }
  }
  mark({Mat3::Identity(), Vec3::Zero(), 1});
  take();
  EXPECT_FALSE(taken(100, 100));
  EXPECT_TRUE(taken(200, 100));
}

TEST_F(KnownGroundTest, GroundWithoutDepthIsNotKnown) {
  depths_->fill(0);
  mark({Mat3::Identity(), Vec3::Zero(), 1});
  EXPECT_EQ(take(), 0U);
}

TEST_F(KnownGroundTest, ACameraThatLooksAwayKnowsNothing) {
  Mat3 up = Mat3::Identity();
  up(1, 1) = up(2, 2) = -1;
  mark({up, Vec3::Zero(), 1});
  EXPECT_EQ(take(), 0U);
}

TEST_F(KnownGroundTest, WithoutDepthThePlaneTells) {
  Mat3 other_from_keyframe = Mat3::Identity();
  other_from_keyframe(0, 2) = -160;
  mark_known_over_plane(mask(), other_from_keyframe, *other_, *known_);
  EXPECT_GT(take(), 0U);
  EXPECT_FALSE(taken(100, 100));
  EXPECT_TRUE(taken(200, 100));
}

TEST_F(KnownGroundTest, HolesOfTheMaskMakeNoBorder) {
  mark({Mat3::Identity(), Vec3::Zero(), 1});
  // A strip without depth is not in the mask and not known.
  for (int y = 0; y < camera_.height; ++y) {
    for (int x = 152; x < 160; ++x) mask_[static_cast<std::size_t>(y * camera_.width + x)] = 0;
  }
  for (std::int32_t row = 0; row < seen_->rows; ++row)
    (*known_)[static_cast<std::size_t>(row * seen_->columns + 19)] = 0;
  take();
  EXPECT_TRUE(taken(150, 100));
  EXPECT_TRUE(taken(161, 100));
}

}  // namespace
}  // namespace ilp
