#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "sim/host/reference_cameras.hpp"
#include "tests/unit/host/scratch_folder.hpp"

namespace ilp::host {
namespace {

using test::error_of;
using test::says;
using test::ScratchFolder;

const std::string identity_pose = " 640 480 500 501 319.5 239.5 1 0 0 0 1 0 0 0 1 7 8 9\n";

TEST(ReferenceCameras, ReadsTheDocumentedOrder) {
  const ScratchFolder folder;
  const auto path = folder.write("poses.txt",
                                 "# comment\n\na.png 640 480 500 501 319.5 239.5 0 1 0 -1 0 0 0 0 1 7 8 9\n"
                                 "  b.png" +
                                     identity_pose);
  const std::vector<ReferenceCamera> cameras = read_reference_cameras(path);
  ASSERT_EQ(cameras.size(), 2U);
  const ReferenceCamera& a = cameras[0];
  EXPECT_EQ(a.name, "a.png");
  EXPECT_EQ(a.camera.width, 640);
  EXPECT_EQ(a.camera.height, 480);
  EXPECT_EQ(a.camera.fx, 500);
  EXPECT_EQ(a.camera.fy, 501);
  EXPECT_EQ(a.camera.cx, 319.5);
  EXPECT_EQ(a.camera.cy, 239.5);
  // Row by row: the first row is the camera's x axis in the world.
  EXPECT_EQ(a.cam_from_world.row(0).transpose(), Vec3(0, 1, 0));
  EXPECT_EQ(a.cam_from_world.row(1).transpose(), Vec3(-1, 0, 0));
  EXPECT_EQ(a.centre, Vec3(7, 8, 9));
  EXPECT_EQ(cameras[1].name, "b.png");
}

TEST(ReferenceCameras, WrittenPosesReadBackToTheBit) {
  const ScratchFolder folder;
  ReferenceCamera c;
  c.name = "frame.pgm";
  c.camera = {640, 480, 500.0 / 3, 1e-3 + 500, 319.5, 239.1, 0, 0, 0, 0};
  c.cam_from_world = Eigen::AngleAxisd(0.3, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  c.centre = Vec3(1e-17, -123456.789, 1.0 / 3);
  write_reference_cameras(folder / "poses.txt", "world in metres", {c});
  const std::vector<ReferenceCamera> back = read_reference_cameras(folder / "poses.txt");
  ASSERT_EQ(back.size(), 1U);
  EXPECT_EQ(back[0].name, c.name);
  EXPECT_EQ(back[0].camera.fx, c.camera.fx);
  EXPECT_EQ(back[0].camera.fy, c.camera.fy);
  EXPECT_EQ(back[0].cam_from_world, c.cam_from_world);
  EXPECT_EQ(back[0].centre, c.centre);
  c.name = "two words";
  EXPECT_TRUE(says(error_of([&] { write_reference_cameras(folder / "p", "", {c}); }), "'two words'"));
}

TEST(ReferenceCameras, RealReferencePosesLookDown) {
  const std::string path = "../shared/data/aerial_caliterra_a/cameras.txt";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "the shared test data are not here";
  const std::vector<ReferenceCamera> cameras = read_reference_cameras(path);
  ASSERT_EQ(cameras.size(), 7U);
  for (const ReferenceCamera& c : cameras) {
    EXPECT_LT(c.cam_from_world(2, 2), -0.98) << c.name;
    EXPECT_NEAR(c.centre.z(), 51, 2) << c.name;
  }
}

TEST(ReferenceCameras, BadFilesAreRefusedWithTheLineAndTheReason) {
  const ScratchFolder folder;
  struct Case {
    std::string text;
    const char* reason;
  };
  const Case cases[] = {
      {"# nothing\n", "holds no pose"},
      {"a.png 640 480 500 501 319.5 239.5 1 0 0 0 1 0 0 0 1 7 8\n", "line 1: expected 19 words"},
      {"a.png" + identity_pose + "a.png" + identity_pose, "line 2: a second pose for 'a.png'"},
      {"a.png 640.5 480 500 501 319.5 239.5 1 0 0 0 1 0 0 0 1 7 8 9\n", "'640.5' is not an image size"},
      {"a.png 1e300 480 500 501 319.5 239.5 1 0 0 0 1 0 0 0 1 7 8 9\n", "'1e300' is not an image size"},
      {"a.png 640 480 0 501 319.5 239.5 1 0 0 0 1 0 0 0 1 7 8 9\n", "focal length is not positive"},
      {"a.png 640 480 500 501 319.5 239.5 1 0 0 0 1 0 0 0 -1 7 8 9\n", "not a rotation"},
      {"a.png 640 480 500 501 319.5 239.5 2 0 0 0 1 0 0 0 1 7 8 9\n", "not a rotation"},
      {"a.png 640 480 500 501 319.5 239.5 1 0 0 0 1 0 0 0 1 7 nan 9\n", "'nan' is not a finite number"},
      {"a.png 640 480 500 501 319.5 239.5 1 0 0 0 1 0 0 0 1 7 8 9m\n", "'9m' is not a finite number"},
  };
  for (const Case& bad : cases) {
    const std::string message = error_of([&] { (void)read_reference_cameras(folder.write("poses.txt", bad.text)); });
    EXPECT_TRUE(says(message, bad.reason)) << bad.text;
    EXPECT_TRUE(says(message, "poses.txt")) << bad.text;
  }
  EXPECT_TRUE(says(error_of([&] { (void)read_reference_cameras(folder / "none.txt"); }), "none.txt cannot be read"));
}

}  // namespace
}  // namespace ilp::host
