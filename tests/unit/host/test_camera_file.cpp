// Camera files of OpenCV, ROS and Kalibr, as these programs write them, and cameras for images of another size.
#include "sim/host/camera_file.hpp"

#include <gtest/gtest.h>

#include <sstream>

#include "sim/host/colmap.hpp"
#include "tests/unit/host/scratch_folder.hpp"

namespace ilp::host {
namespace {

using test::error_of;
using test::says;
using test::ScratchFolder;

CameraModel read(const ScratchFolder& folder, const std::string& text) {
  return read_camera_file(folder.write("camera.yml", text));
}

/// Of OpenCV's FileStorage, with what its calibration example writes.
std::string opencv_file(const std::string& coefficients, const std::string& more = "") {
  std::size_t count = 1;
  for (const char c : coefficients) count += c == ',' ? 1 : 0;
  return "%YAML:1.0\n---\ncalibration_time: \"Sat Nov 14 12:00:00 2026\"\nnr_of_frames: 12\nimage_width: 640\n"
         "image_height: 480\n" +
         more +
         "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
         "   data: [ 5.0e+02, 0., 3.22e+02, 0., 5.05e+02, 2.36e+02, 0., 0., 1. ]\n"
         "distortion_coefficients: !!opencv-matrix\n   rows: " +
         std::to_string(count) + "\n   cols: 1\n   dt: d\n   data: [ " + coefficients + " ]\n";
}

const std::string kalibr_file =
    "cam0:\n  cam_overlaps: []\n  camera_model: pinhole\n"
    "  distortion_coeffs: [-0.02, 0.013, -0.006, 0.0011]\n  distortion_model: equidistant\n"
    "  intrinsics: [500.0, 505.0, 322.0, 236.0]\n  resolution: [640, 480]\n  rostopic: /cam0/image_raw\n";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

class CameraFile : public testing::Test {
 protected:
  void SetUp() override {
    if (says(error_of([&] { (void)read(folder, "a: 1\n"); }), "libyaml")) GTEST_SKIP() << "built without libyaml";
  }
  const ScratchFolder folder;
};

TEST_F(CameraFile, OfOpenCvHasItsOrderOfCoefficients) {
  CameraModel c = read(folder, opencv_file("-0.28, 0.07, 6.0e-04, -3.0e-04, -0.02"));
  const CameraModel expected{640, 480, 500, 505, 322, 236, -0.28, 0.07, 6e-4, -3e-4, -0.02, 0, 0, 0, Lens::brown};
  EXPECT_TRUE(c == expected);
  c = read(folder, opencv_file("0.35, -0.11, 6e-4, -3e-4, 0.015, 0.61, -0.08, 0.03"));
  EXPECT_EQ(c.k3, 0.015);
  EXPECT_EQ(c.k4, 0.61);
  EXPECT_EQ(c.k6, 0.03);
  EXPECT_EQ(read(folder, opencv_file("-0.28, 0.07, 0, 0")).k3, 0);
  // Twelve with a thin prism of nought.
  EXPECT_EQ(read(folder, opencv_file("0.35, -0.11, 6e-4, -3e-4, 0.015, 0.61, -0.08, 0.03, 0, 0, 0, 0")).k5, -0.08);
}

TEST_F(CameraFile, SaysByAWordThatItIsAFisheye) {
  for (const char* word : {"distortion_model: fisheye\n", "distortion_model: equidistant\n", "fisheye_model: 1\n"}) {
    const CameraModel c = read(folder, opencv_file("-0.02, 0.013, -0.006, 0.0011", word));
    EXPECT_EQ(c.lens, Lens::fisheye) << word;
    EXPECT_EQ(c.k3, -0.006);
    EXPECT_EQ(c.k4, 0.0011);
    EXPECT_EQ(c.p1, 0);
  }
  EXPECT_EQ(read(folder, opencv_file("-0.02, 0.013, 0, 0", "fisheye_model: 0\n")).lens, Lens::brown);
  EXPECT_EQ(read(folder, opencv_file("-0.02, 0.013, 0, 0", "distortion_model: plumb_bob\n")).lens, Lens::brown);
}

TEST_F(CameraFile, OfLargerImagesThanTheFlightTakesIsReadWhereTheyAreReduced) {
  const std::string large = replaced(kalibr_file, "[500.0, 505.0, 322.0, 236.0]\n  resolution: [640, 480]",
                                     "[5000.0, 5050.0, 3220.0, 2360.0]\n  resolution: [6400, 4800]");
  EXPECT_EQ(read(folder, large).width, 6400);
  const auto as_they_are = [&] { (void)read_global_shutter_camera(folder.write("camera.yml", large)); };
  EXPECT_TRUE(says(error_of(as_they_are), "6400 px x 4800 px"));
  const std::string of_opencv = replaced(opencv_file("-0.28, 0.07, 0, 0"), "image_width: 640\nimage_height: 480",
                                         "image_width: 1640\nimage_height: 1480");
  EXPECT_EQ(read(folder, of_opencv).height, 1480);
}

TEST_F(CameraFile, OfKalibrIsRead) {
  CameraModel c = read(folder, kalibr_file);
  const CameraModel expected{640, 480, 500, 505, 322, 236, -0.02, 0.013, 0, 0, -0.006, 0.0011, 0, 0, Lens::fisheye};
  EXPECT_TRUE(c == expected);
  c = read(folder, replaced(kalibr_file, "equidistant", "radtan"));
  EXPECT_EQ(c.lens, Lens::brown);
  EXPECT_EQ(c.p1, -0.006);
  EXPECT_EQ(c.p2, 0.0011);
  EXPECT_EQ(c.k3, 0);
}

TEST_F(CameraFile, OfColmapIsToldByItsContent) {
  EXPECT_EQ(read(folder, "# list\n1 PINHOLE 640 480 500 500 320 240\n").cx, 319.5);
}

TEST_F(CameraFile, ThatIsBadIsRefusedByName) {
  struct Case {
    std::string text;
    const char* reason;
  };
  const std::string good = opencv_file("-0.28, 0.07, 0, 0, 0");
  const Case cases[] = {
      {"a: 1\n", "neither camera_matrix (OpenCV, ROS) nor cam0 (Kalibr)"},
      {"a: [1\n", "line 2: no YAML"},
      {"<?xml version=\"1.0\"?>\n", "it is XML"},
      {replaced(good, "image_width: 640\n", ""), "image_width is missing"},
      {replaced(good, "image_width: 640", "image_width: 640.5"), "the image size"},
      {replaced(good, "image_width: 640", "image_width: wide"), "image_width: 'wide' is not a finite number"},
      {replaced(good, "5.0e+02, 0.,", "5.0e+02, 1.5,"), "camera_matrix is not [fx 0 cx"},
      {replaced(good, "5.0e+02", ".nan"), "camera_matrix: '.nan' is not a finite number"},
      {replaced(good, "5.0e+02, ", ""), "camera_matrix has 8 numbers, not rows times cols"},
      {replaced(good, "5.0e+02", "-5.0e+02"), "focal length"},
      {opencv_file("-3, 0, 0, 0"), "distortion"},
      {opencv_file("0.1, 0.2, 0.3"), "distortion_coefficients has 3 numbers"},
      {opencv_file("0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0, 0, 0"), "thin prism"},
      {opencv_file("0, 0, 0, 0, 0", "distortion_model: fisheye\n"), "a fisheye has four"},
      {opencv_file("0, 0, 0, 0", "distortion_model: mei\n"), "distortion_model mei is not supported"},
      {replaced(good, "image_height", "image_width"), "image_width is there twice"},
      {kalibr_file + replaced(kalibr_file, "cam0", "cam1"), "several cameras (cam0, cam1"},
      {replaced(kalibr_file, "pinhole", "omni"), "camera_model omni is not supported"},
      {replaced(kalibr_file, "equidistant", "fov"), "distortion_model fov is not supported"},
      {replaced(kalibr_file, "[640, 480]", "[640]"), "resolution is not width and height"},
      {replaced(kalibr_file, "[640, 480]", "480"), "resolution is not a list of numbers"},
      {replaced(kalibr_file, "500.0, 505.0", "200.0, 200.0"), "75 deg"},
      {replaced(kalibr_file, "-0.02, 0.013", "-0.02, -1"), "distortion"},
  };
  for (const Case& bad : cases) {
    const std::string error = error_of([&] { (void)read(folder, bad.text); });
    EXPECT_TRUE(says(error, bad.reason)) << bad.text;
    EXPECT_TRUE(says(error, "camera.yml"));
  }
  EXPECT_TRUE(says(error_of([&] { (void)read_camera_file(folder / "none.yml"); }), "none.yml cannot be read"));
}

// A fold, scale and crop of the same picture: the ray of a place in it stays.
TEST(CameraForSize, ScalesWithTheImage) {
  const CameraModel c{4056, 3040, 3000, 3010, 2050, 1500, -0.1, 0.02, 1e-3, 0};
  std::ostringstream messages;
  const CameraModel small = camera_for_size(c, 640, 480, "a.jpg has", messages);
  EXPECT_TRUE(says(messages.str(), "a.jpg has 640x480 pixels, the camera file says 4056x3040: scaled"));
  EXPECT_EQ(small.width, 640);
  EXPECT_EQ(small.k1, c.k1);
  for (const double at : {0.0, 0.3, 1.0}) {
    // Places from the left border in widths, and from the upper one in heights.
    EXPECT_NEAR((at * 640 - 0.5 - small.cx) / small.fx, (at * 4056 - 0.5 - c.cx) / c.fx, 1e-12);
    EXPECT_NEAR((at * 480 - 0.5 - small.cy) / small.fy, (at * 3040 - 0.5 - c.cy) / c.fy, 1e-12);
  }
  std::ostringstream silent;
  EXPECT_TRUE(camera_for_size(c, 4056, 3040, "a.jpg has", silent) == c);
  EXPECT_EQ(silent.str(), "");
  EXPECT_NO_THROW((void)camera_for_size(small, 4056, 3040, "a.jpg has", messages));
}

TEST(CameraForSize, OfAnotherShapeIsRefused) {
  const CameraModel c{4056, 3040, 3000, 3010, 2050, 1500, 0, 0, 0, 0};
  std::ostringstream messages;
  const auto refusal = [&](std::int32_t width, std::int32_t height) {
    return error_of([&] { (void)camera_for_size(c, width, height, "a.jpg has", messages); });
  };
  EXPECT_TRUE(
      says(refusal(1920, 1080), "a.jpg has 1920x1080 pixels, the camera file says 4056x3040: of another shape"));
  EXPECT_TRUE(says(refusal(3040, 4056), "turned upright"));
  EXPECT_TRUE(says(refusal(640, 478), "of another shape"));
}

}  // namespace
}  // namespace ilp::host
