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
  void mark(const Similarity& other_from_camera) {
    mark_known({mask(), *seen_, *depths_, camera_}, {*other_, other_from_camera}, 1.8, *known_);
  }
  [[nodiscard]] MaskView mask() const { return {mask_.data(), camera_.width, camera_.height}; }
  std::uint32_t take() {
    return take_known(*known_, 2, ImageView<std::uint8_t>(mask_.data(), camera_.width, camera_.height));
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

TEST_F(KnownGroundTest, AViewThatIsALittleFinerDoesNot) {
  fill(*other_, 1.4 * distance);
  mark({Mat3::Identity(), Vec3(0, 0, 0.4 * distance), 1});
  EXPECT_EQ(take(), mask_.size());
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
