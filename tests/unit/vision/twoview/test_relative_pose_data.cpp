// The relative pose against ground truth and against what PoseLib reaches on the same files (README of the data).
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>

#include "fsw/vision/twoview/robust/two_view_workspace.hpp"
#include "fsw/vision/twoview/two_view.hpp"
#include "tests/unit/vision/twoview/relative_pose_floor.hpp"

namespace ilp {
namespace {

const char* const synthetic_dir = "../shared/data/relative_pose_synthetic";
const char* const strecha_dir = "../shared/data/relative_pose_strecha";

TwoViewWorkspace workspace;
test::PoseCase pose_case;

struct Cell {
  std::vector<double> rotation, direction;
  int failures = 0;
};

/// Medians over 60 trials that PoseLib reaches, degrees; the files here are the first four of each cell, so that a cell
/// may lie above its bar by luck: half as much again is allowed.
struct Bar {
  int scene, outliers, noise;
  double rotation, direction;
};
constexpr Bar bars[] = {
    {0, 30, 5, 0.086, 0.20}, {0, 50, 10, 0.19, 0.43}, {1, 30, 5, 0.15, 0.52}, {1, 50, 5, 0.21, 0.81},
    {3, 30, 10, 0.32, 1.45}, {4, 30, 5, 0.13, 0.47},  {2, 30, 5, 0.15, 0.50}, {5, 30, 5, 0.23, 1.57},
};
constexpr double luck = 1.5;

TEST(RelativePoseData, Synthetic) {
  if (!std::filesystem::exists(synthetic_dir)) GTEST_SKIP() << "no " << synthetic_dir;
  std::printf("scene outliers noise  rotation direction (median, degrees)  from truth  worst  failures\n");
  for (int scene = 0; scene < 6; ++scene) {
    for (const int outliers : {30, 50}) {
      for (const int noise : {5, 10}) {
        Cell cell;
        Cell floor;
        for (int trial = 0; trial < 4; ++trial) {
          char path[256];
          std::snprintf(path, sizeof(path), "%s/%d_o%02d_n%02d_%03d.txt", synthetic_dir, scene, outliers, noise, trial);
          ASSERT_TRUE(test::read_synthetic(path, pose_case)) << path;
          const RigidTransform best = test::least_squares_from_truth(pose_case, workspace);
          floor.rotation.push_back(test::rotation_error_deg(best, pose_case.truth));
          floor.direction.push_back(test::direction_error_deg(best, pose_case.truth));
          for (std::uint64_t seed = 1; seed <= 3; ++seed) {
            RansacParams params{.threshold_px = 0.2 * noise, .seed = seed};
            InlierMask inliers;
            TwoViewResult result;
            ASSERT_TRUE(estimate_two_view(pose_case.pairs, pose_case.camera, pose_case.camera, params, workspace,
                                          inliers, result)
                            .ok());
            const double rotation = test::rotation_error_deg(result.b_from_a, pose_case.truth);
            const double direction = test::direction_error_deg(result.b_from_a, pose_case.truth);
            cell.rotation.push_back(rotation);
            cell.direction.push_back(direction);
            if (rotation > 10 || direction > 10) ++cell.failures;
          }
        }
        std::printf(
            "%d     %d       %.1f      %.3f    %.2f   %.3f %.2f            %.3f %.2f    %d of %zu\n", scene, outliers,
            0.1 * noise, test::median(cell.rotation), test::median(cell.direction), test::median(floor.rotation),
            test::median(floor.direction), *std::max_element(cell.rotation.begin(), cell.rotation.end()),
            *std::max_element(cell.direction.begin(), cell.direction.end()), cell.failures, cell.rotation.size());
        EXPECT_EQ(cell.failures, 0);
        for (const Bar& bar : bars) {
          if (bar.scene != scene || bar.outliers != outliers || bar.noise != noise) continue;
          EXPECT_LT(test::median(cell.rotation), luck * bar.rotation) << "scene " << scene;
          EXPECT_LT(test::median(cell.direction), luck * bar.direction) << "scene " << scene;
        }
      }
    }
  }
}

TEST(RelativePoseData, Strecha) {
  if (!std::filesystem::exists(strecha_dir)) GTEST_SKIP() << "no " << strecha_dir;
  for (const char* name : {"fountain_0000_0001", "fountain_0004_0005", "fountain_0005_0007", "fountain_0009_0010",
                           "entry_0000_0001", "entry_0004_0005", "entry_0007_0008"}) {
    ASSERT_TRUE(test::read_strecha(std::string(strecha_dir) + "/" + name + ".txt", pose_case)) << name;
    RansacParams params;
    InlierMask inliers;
    TwoViewResult result;
    ASSERT_TRUE(
        estimate_two_view(pose_case.pairs, pose_case.camera, pose_case.camera, params, workspace, inliers, result)
            .ok());
    std::printf(
        "%-20s %s rotation %.3f direction %.3f deg; sigma %.3f %.3f; inliers %u of %zu; rms %.2f px; parallax %.1f; "
        "gric %.0f %.0f\n",
        name, name_of(result.verdict), test::rotation_error_deg(result.b_from_a, pose_case.truth),
        test::direction_error_deg(result.b_from_a, pose_case.truth), test::degrees * result.sigma_rotation_rad,
        test::degrees * result.sigma_direction_rad, result.inliers, pose_case.pairs.size(), result.rms_px,
        result.median_parallax_px, result.gric_e, result.gric_h);
    EXPECT_LT(test::rotation_error_deg(result.b_from_a, pose_case.truth), 0.3);
    EXPECT_LT(test::direction_error_deg(result.b_from_a, pose_case.truth), 1);
  }
}

}  // namespace
}  // namespace ilp
