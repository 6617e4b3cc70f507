// The coarse map marks the ground that an image shows, where it lies in the world.
#include <gtest/gtest.h>

#include <memory>

#include "fsw/vision/terrain/coverage_grid.hpp"
#include "tests/unit/vision/stereo/analytic_scene.hpp"

namespace ilp::test {
namespace {

struct FlatImage {
  CameraModel camera = distorting_camera();
  RigidTransform pose;
  std::vector<float> inverse_depth, sigma;

  explicit FlatImage(const RigidTransform& cam_from_world) : pose(cam_from_world) {
    for (std::int32_t y = 0; y < camera.height; ++y) {
      for (std::int32_t x = 0; x < camera.width; ++x) {
        const Vec3 ground = ground_point(
            camera, pose, [](double, double) { return 0.0; }, x, y);
        inverse_depth.push_back(static_cast<float>(1 / (pose * ground).z()));
        sigma.push_back(1e-4F);
      }
    }
  }
  Status add(CoverageGrid& grid, GridUpdate& update) const {
    static const auto workspace = std::make_unique<CoverageGridWorkspace>();
    return add_to_grid(camera, pose, {inverse_depth.data(), camera.width, camera.height},
                       {sigma.data(), camera.width, camera.height}, 2, *workspace, grid, update);
  }
};

TEST(CoverageGrid, MarksTheFootprintAndCountsOnlyNewGroundAsNew) {
  const auto grid = std::make_unique<CoverageGrid>();
  ASSERT_TRUE(clear_grid(500, -300, 2, *grid).ok());
  GridUpdate first;
  const FlatImage a(looking_down({500, -300, 100}, {0.05, -0.1, 0.3}));
  ASSERT_TRUE(a.add(*grid, first).ok());
  EXPECT_EQ(first.new_cells, first.cells);
  EXPECT_EQ(first.outside, 0U);
  // A cell is marked exactly when its ground is inside the image, the border aside.
  int wrong = 0;
  int marked = 0;
  for (std::int32_t row = 0; row < coverage_grid_side; ++row) {
    for (std::int32_t column = 0; column < coverage_grid_side; ++column) {
      const Vec3 centre(grid->origin_x + 2 * (column + 0.5), grid->origin_y + 2 * (row + 0.5), 0);
      const bool seen = (a.pose * centre).z() > 0 && inside(a.camera, pixel_of(a.camera, a.pose, centre)) &&
                        std::fabs(centre.x() - 500) < 150 && std::fabs(centre.y() + 300) < 150;
      const bool set = grid->at(column, row) != 0;
      wrong += seen != set ? 1 : 0;
      marked += set ? 1 : 0;
    }
  }
  EXPECT_GT(marked, 1500);
  EXPECT_LT(wrong, 0.12 * marked);

  GridUpdate again;
  ASSERT_TRUE(a.add(*grid, again).ok());
  EXPECT_EQ(again.cells, first.cells);
  EXPECT_EQ(again.new_cells, 0U);
  GridUpdate next;
  ASSERT_TRUE(FlatImage(looking_down({520, -300, 100}, {0.05, -0.1, 0.3})).add(*grid, next).ok());
  EXPECT_NEAR(next.new_cells / static_cast<double>(next.cells), 0.25, 0.1);
}

TEST(CoverageGrid, GroundBeyondTheGridIsCountedNotLost) {
  const auto grid = std::make_unique<CoverageGrid>();
  ASSERT_TRUE(clear_grid(0, 0, 0.1, *grid).ok());
  GridUpdate update;
  ASSERT_TRUE(FlatImage(looking_down({0, 0, 100})).add(*grid, update).ok());
  EXPECT_GT(update.outside, 1000U);
  EXPECT_EQ(clear_grid(0, 0, 0, *grid).code, StatusCode::invalid_argument);
  *grid = {};
  EXPECT_EQ(FlatImage(looking_down({0, 0, 100})).add(*grid, update).code, StatusCode::invalid_argument);
}

}  // namespace
}  // namespace ilp::test
