#include <gtest/gtest.h>

#include "sim/host/colmap.hpp"
#include "tests/unit/host/scratch_folder.hpp"

namespace ilp::host {
namespace {

using test::error_of;
using test::says;
using test::ScratchFolder;

CameraModel read(const ScratchFolder& folder, const std::string& text) {
  return read_colmap_camera(folder.write("cameras.txt", text));
}

// Parameters in the order of COLMAP's src/colmap/sensor/models.h.
TEST(ColmapCamera, ReadsEveryModelWithItsOwnOrderOfParameters) {
  const ScratchFolder folder;
  CameraModel c = read(folder, "# comment\n\n7 PINHOLE 640 480 500 510 320.5 240.25\n");
  EXPECT_EQ(c.width, 640);
  EXPECT_EQ(c.height, 480);
  EXPECT_EQ(c.fx, 500);
  EXPECT_EQ(c.fy, 510);
  EXPECT_EQ(c.cx, 320.0);
  EXPECT_EQ(c.cy, 239.75);
  EXPECT_FALSE(c.has_distortion());

  c = read(folder, "1 SIMPLE_PINHOLE 640 480 500 320 240\n");
  EXPECT_EQ(c.fx, 500);
  EXPECT_EQ(c.fy, 500);
  EXPECT_EQ(c.cx, 319.5);
  EXPECT_EQ(c.cy, 239.5);

  c = read(folder, "1 SIMPLE_RADIAL 640 480 500 320 240 -0.1\n");
  EXPECT_EQ(c.cy, 239.5);
  EXPECT_EQ(c.k1, -0.1);
  EXPECT_EQ(c.k2, 0);

  c = read(folder, "1 RADIAL 640 480 500 320 240 -0.1 0.02\n");
  EXPECT_EQ(c.fy, 500);
  EXPECT_EQ(c.k1, -0.1);
  EXPECT_EQ(c.k2, 0.02);

  c = read(folder, "1 OPENCV 640 480 500 510 320 240 -0.1 0.02 0.001 -0.002\r\n");
  EXPECT_EQ(c.fy, 510);
  EXPECT_EQ(c.k1, -0.1);
  EXPECT_EQ(c.k2, 0.02);
  EXPECT_EQ(c.p1, 0.001);
  EXPECT_EQ(c.p2, -0.002);

  c = read(folder, "1 FULL_OPENCV 640 480 500 510 320 240 -0.1 0.02 0.001 -0.002 0.03 0.04 0.05 0.06\n");
  EXPECT_EQ(c.p2, -0.002);
  EXPECT_EQ(c.k3, 0.03);
  EXPECT_EQ(c.k4, 0.04);
  EXPECT_EQ(c.k6, 0.06);
  EXPECT_EQ(c.lens, Lens::brown);

  c = read(folder, "1 OPENCV_FISHEYE 640 480 500 510 320 240 -0.02 0.013 -0.006 0.0011\n");
  EXPECT_EQ(c.lens, Lens::fisheye);
  EXPECT_EQ(c.k2, 0.013);
  EXPECT_EQ(c.k3, -0.006);
  EXPECT_EQ(c.k4, 0.0011);
  EXPECT_EQ(c.p1, 0);

  c = read(folder, "1 RADIAL_FISHEYE 640 480 500 320 240 -0.02 0.013\n");
  EXPECT_EQ(c.lens, Lens::fisheye);
  EXPECT_EQ(c.fy, 500);
  EXPECT_EQ(c.k2, 0.013);
}

TEST(ColmapCamera, WrittenFileReadsBackTheSame) {
  const ScratchFolder folder;
  CameraModel c{640, 480, 1.0 / 3 + 500, 501, 319.1, 240.7, 0, 0, 0, 0};
  write_colmap_camera(folder / "pinhole.txt", c);
  CameraModel back = read_colmap_camera(folder / "pinhole.txt");
  EXPECT_EQ(back.fx, c.fx);
  EXPECT_NEAR(back.cx, c.cx, 1e-12);
  EXPECT_NEAR(back.cy, c.cy, 1e-12);
  c.k1 = -0.07;
  c.p2 = 1e-4;
  write_colmap_camera(folder / "opencv.txt", c);
  back = read_colmap_camera(folder / "opencv.txt");
  EXPECT_EQ(back.k1, c.k1);
  EXPECT_EQ(back.k2, 0);
  EXPECT_EQ(back.p1, 0);
  EXPECT_EQ(back.p2, c.p2);
  for (const Lens lens : {Lens::brown, Lens::fisheye}) {
    // Pixel centres of 0.5 in the file: exact with these.
    CameraModel more{640, 480, 500, 501, 319.25, 240.75, -0.07, 0.01, 0, 0, 0.003, -0.0004, 0, 0, lens};
    if (lens == Lens::brown) more.p1 = more.k6 = 1.0 / 1024;
    write_colmap_camera(folder / "more.txt", more);
    EXPECT_TRUE(read_colmap_camera(folder / "more.txt") == more);
  }
}

TEST(ColmapCamera, OfLargerImagesThanTheFlightTakesIsRead) {
  const ScratchFolder folder;
  const CameraModel c = read(folder, "1 OPENCV 8000 6000 7000 7000 4000 3000 -0.08 0.01 0.0004 -0.0003\n");
  EXPECT_EQ(c.width, 8000);
  EXPECT_EQ(c.cy, 2999.5);
}

TEST(ColmapCamera, BadFilesAreRefusedWithTheLineAndTheReason) {
  const ScratchFolder folder;
  struct Case {
    const char* text;
    const char* reason;
  };
  const Case cases[] = {
      {"", "holds no camera"},
      {"# only a comment\n", "holds no camera"},
      {"#\n1 PINHOLE 640\n", "line 2: expected CAMERA_ID MODEL WIDTH HEIGHT"},
      {"1 FISHEYE 640 480 500 320 240 0\n", "FISHEYE is not supported"},
      {"1 PINHOLE 640 480 500 500 320\n", "PINHOLE has 4 parameters, found 3"},
      {"1 PINHOLE 640 480 500 500 320 240 0\n", "PINHOLE has 4 parameters, found 5"},
      {"1 PINHOLE 640 480 500 500 320 24O\n", "'24O' is not a finite number"},
      {"1 PINHOLE 640 480 nan 500 320 240\n", "'nan' is not a finite number"},
      {"1 PINHOLE 640 480 1e999 500 320 240\n", "'1e999' is not a finite number"},
      {"1 PINHOLE 640 480 -500 500 320 240\n", "focal length"},
      {"1 PINHOLE 640 480 500 0 320 240\n", "focal length"},
      {"1 PINHOLE 640 480 inf 500 320 240\n", "'inf' is not a finite number"},
      {"1 PINHOLE 640 480 1e30 1e30 320 240\n", "focal length"},
      {"1 PINHOLE 640 480 500 50000 320 240\n", "focal length"},
      {"1 PINHOLE 640 480 0.5 0.5 320 240\n", "focal length"},
      {"1 PINHOLE 640 480 500 500 320 -inf\n", "'-inf' is not a finite number"},
      {"1 OPENCV 640 480 500 500 320 240 nan 0 0 0\n", "'nan' is not a finite number"},
      {"1 OPENCV 640 480 500 500 320 240 0 0 5 0\n", "distortion"},
      {"1 PINHOLE 0 480 500 500 320 240\n", "image size"},
      {"1 PINHOLE -640 480 500 500 320 240\n", "image size"},
      {"1 PINHOLE 64000 480 500 500 320 240\n", "64000"},
      {"1 PINHOLE 99999999999999999999 480 500 500 320 240\n", "expected CAMERA_ID MODEL WIDTH HEIGHT"},
      {"1 PINHOLE 640 480 500 500 1e9 240\n", "principal point"},
      {"1 RADIAL 640 480 500 320 240 -3 0\n", "distortion"},
      {"1 OPENCV_FISHEYE 640 480 200 200 320 240 0 0 0 0\n", "75 deg from the optical axis"},
      {"1 THIN_PRISM_FISHEYE 640 480 500 500 320 240 0 0 0 0 0 0 0 0\n", "THIN_PRISM_FISHEYE is not supported"},
      {"1 PINHOLE 640 480 500 500 320 240\n\n2 PINHOLE 640 480 500 500 320 240\n", "has several cameras (1, 2"},
  };
  for (const Case& bad : cases) {
    EXPECT_TRUE(says(error_of([&] { (void)read(folder, bad.text); }), bad.reason)) << bad.text;
  }
  EXPECT_TRUE(says(error_of([&] { (void)read_colmap_camera(folder / "none.txt"); }), "none.txt"));
}

}  // namespace
}  // namespace ilp::host
