// ilp-lab calibrate-target on rendered pictures of a chessboard and of ChArUco boards, whose camera is known.

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <sstream>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/host/colmap.hpp"
#include "sim/host/image_io.hpp"
#include "tests/integration/charuco_pattern.hpp"
#include "tests/integration/lab_program.hpp"

namespace ilp::test {
namespace {

struct RenderedCamera {
  int width = 640, height = 480;
  double fx = 620, fy = 616, cx = 327, cy = 234;
  double k1 = -0.18, k2 = 0.05, p1 = 0.002, p2 = -0.0015;

  /// The direction in which a pixel looks, by fixed-point iteration on Brown's equations.
  [[nodiscard]] Vec3 ray(double u, double v) const {
    const double xd = (u - cx) / fx, yd = (v - cy) / fy;
    double x = xd, y = yd;
    for (int i = 0; i < 30; ++i) {
      const double r2 = x * x + y * y, radial = 1 + k1 * r2 + k2 * r2 * r2;
      x = (xd - 2 * p1 * x * y - p2 * (r2 + 2 * x * x)) / radial;
      y = (yd - p1 * (r2 + 2 * y * y) - 2 * p2 * x * y) / radial;
    }
    return {x, y, 1};
  }
};

constexpr int columns = 9, rows = 6;  // inner corners
constexpr double square_m = 0.03;

constexpr int samples = 4;  // each way in a pixel

/// Of all samples of the picture, row by row.
std::vector<Vec3> rays_of(const RenderedCamera& camera) {
  std::vector<Vec3> rays;
  for (int y = 0; y < camera.height * samples; ++y) {
    for (int x = 0; x < camera.width * samples; ++x) {
      rays.push_back(camera.ray((x + 0.5) / samples - 0.5, (y + 0.5) / samples - 0.5));
    }
  }
  return rays;
}

/// Grey values at a place of the board, whose first square begins at (-1, -1), in squares.
using Pattern = std::function<double(double column, double row)>;

double chessboard(double column, double row) {
  if (column < -2 || row < -2 || column >= columns + 1 || row >= rows + 1) return 110;
  const bool on_squares = column > -1 && row > -1 && column < columns && row < rows;
  const bool black = (static_cast<int>(std::floor(column)) + static_cast<int>(std::floor(row))) % 2 == 0;
  return on_squares && black ? 25 : 225;
}

void render(const RenderedCamera& camera, const Vec3& turn, const Vec3& centre_m, const std::string& path,
            const Pattern& pattern = chessboard) {
  static const std::vector<Vec3> usual_rays = rays_of({});
  const std::vector<Vec3> other_rays = camera.width == RenderedCamera{}.width ? std::vector<Vec3>{} : rays_of(camera);
  const std::vector<Vec3>& rays = other_rays.empty() ? usual_rays : other_rays;
  const Mat3 camera_from_board = rotation_from_vector(turn);
  const Vec3 middle(0.5 * (columns - 1) * square_m, 0.5 * (rows - 1) * square_m, 0);
  const Vec3 origin = centre_m - camera_from_board * middle;
  const Vec3 eye = camera_from_board.transpose() * -origin;  // in the board's axes
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height));
  const Mat3 board_from_camera = camera_from_board.transpose();
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      double sum = 0;
      for (int sample = 0; sample < samples * samples; ++sample) {
        const int row_of_rays = y * samples + sample / samples, ray_in_row = x * samples + sample % samples;
        const Vec3 ray =
            board_from_camera * rays[static_cast<std::size_t>(row_of_rays * camera.width * samples + ray_in_row)];
        const double along = -eye.z() / ray.z();
        sum +=
            along > 0 ? pattern((eye.x() + along * ray.x()) / square_m, (eye.y() + along * ray.y()) / square_m) : 110;
      }
      pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width) + static_cast<std::size_t>(x)] =
          static_cast<std::uint8_t>(std::lround(sum / (samples * samples)));
    }
  }
  host::write_png(path, ImageView<const std::uint8_t>{pixels.data(), camera.width, camera.height, camera.width});
}

const std::array<std::array<double, 6>, 8> poses = {{{0.5, 0.1, 0.05, 0.00, 0.00, 0.42},
                                                     {-0.45, 0.2, -0.1, 0.03, 0.02, 0.45},
                                                     {0.1, 0.55, 0.2, -0.05, 0.03, 0.46},
                                                     {0.15, -0.5, 0.1, 0.06, -0.03, 0.47},
                                                     {0.35, 0.4, 1.4, 0.02, -0.02, 0.45},
                                                     {-0.3, -0.35, 0.6, -0.06, -0.04, 0.50},
                                                     {0.05, -0.1, 0.0, 0.07, 0.05, 0.48},
                                                     {-0.2, 0.5, -0.3, 0.08, -0.05, 0.50}}};

class LabCalibrateTarget : public LabTest {
 protected:
  void SetUp() override {
    LabTest::SetUp();
    const LabRun run = lab("calibrate-target " + grey("grey.png", 64, 48));
    if (run.err.find("this build has no OpenCV") == std::string::npos) return;
    EXPECT_EQ(run.status, 1);
    EXPECT_NE(run.err.find("apt-get install libopencv-calib3d-dev"), std::string::npos) << run.err;
    GTEST_SKIP() << "this build has no OpenCV";
  }
  std::string grey(const std::string& name, int width, int height) const {
    const std::vector<std::uint8_t> pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 120);
    host::write_png(path(name), ImageView<const std::uint8_t>{pixels.data(), width, height, width});
    return path(name);
  }
  std::string board(std::size_t pose, const RenderedCamera& camera = {}) const {
    const std::array<double, 6>& p = poses.at(pose);
    const std::string file = path("board-" + std::to_string(pose) + ".png");
    render(camera, {p[0], p[1], p[2]}, {p[3], p[4], p[5]}, file);
    return file;
  }
  /// The file camera.txt has the camera, and its lens to a pixel near the borders.
  void expect_camera(const RenderedCamera& truth, double focal_px = 0.6) const {
    const CameraModel found = host::read_colmap_camera(path("camera.txt"));
    EXPECT_EQ(found.width, truth.width);
    EXPECT_EQ(found.height, truth.height);
    // 0.6 is a thousandth.
    EXPECT_NEAR(found.fx, truth.fx, focal_px);
    EXPECT_NEAR(found.fy, truth.fy, focal_px);
    EXPECT_NEAR(found.cx, truth.cx, 1);
    EXPECT_NEAR(found.cy, truth.cy, 1);
    // What the flight makes of the corner of the picture: distortion and all.
    for (const auto& [u, v] : {std::pair{40.0, 40.0}, {600.0, 440.0}, {320.0, 30.0}}) {
      const Vec3 ray = truth.ray(u, v);
      const double r2 = ray.x() * ray.x() + ray.y() * ray.y(), radial = 1 + found.k1 * r2 + found.k2 * r2 * r2;
      const double x = ray.x() * radial + 2 * found.p1 * ray.x() * ray.y() + found.p2 * (r2 + 2 * ray.x() * ray.x());
      const double y = ray.y() * radial + found.p1 * (r2 + 2 * ray.y() * ray.y()) + 2 * found.p2 * ray.x() * ray.y();
      EXPECT_NEAR(found.fx * x + found.cx, u, 1) << u << " " << v;
      EXPECT_NEAR(found.fy * y + found.cy, v, 1) << u << " " << v;
    }
  }
  void refused(const std::string& arguments, int status, const std::string& part) const {
    const LabRun run = lab("calibrate-target " + arguments + " --out " + path("camera.txt"));
    EXPECT_EQ(run.status, status) << arguments << "\n" << run.err;
    EXPECT_NE(run.err.find(part), std::string::npos) << arguments << "\n" << run.err;
    EXPECT_FALSE(std::filesystem::exists(path("camera.txt")));
  }
};

TEST_F(LabCalibrateTarget, FindsTheCameraOfRenderedBoards) {
  const RenderedCamera truth;
  std::string pictures;
  for (std::size_t i = 0; i < poses.size(); ++i) pictures += board(i) + " ";
  const LabRun run = lab_done("calibrate-target " + pictures + "--board 9x6 --out " + path("camera.txt") +
                              " --picture " + path("residuals.svg"));
  EXPECT_EQ(run.json.at("pictures").size(), poses.size()) << run.out;
  EXPECT_LT(run.number("rms_px"), 0.1);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto& picture = run.json.at("pictures").at(i);
    EXPECT_LT(picture.at("rms_px").get<double>(), 0.2);
    // Of the board's normal against the line of sight.
    const double cosine = rotation_from_vector({poses.at(i)[0], poses.at(i)[1], poses.at(i)[2]})(2, 2);
    EXPECT_NEAR(std::cos(picture.at("tilt_deg").get<double>() / 180 * 3.14159265358979323846), cosine, 0.005) << i;
  }
  expect_camera(truth);
  for (const char* sigma : {"sigma_fx", "sigma_fy", "sigma_cx", "sigma_cy"}) {
    EXPECT_GT(run.number(sigma), 0) << sigma;
    EXPECT_LT(run.number(sigma), 0.6) << sigma;
  }
  std::ifstream svg(path("residuals.svg"));
  const std::string text{std::istreambuf_iterator<char>(svg), {}};
  EXPECT_NE(text.find("board-0.png"), std::string::npos);
  EXPECT_NE(text.find("</svg>"), std::string::npos);
}

TEST_F(LabCalibrateTarget, PicturesWithoutTheBoardAreNamedAndLeftOut) {
  std::string pictures;
  for (std::size_t i = 0; i < 5; ++i) pictures += board(i) + " ";
  const LabRun run = lab_done("calibrate-target " + pictures + grey("empty.png", 640, 480));
  EXPECT_EQ(run.json.at("pictures").size(), 5U);
  ASSERT_EQ(run.json.at("without_board").size(), 1U);
  EXPECT_EQ(run.json.at("without_board").at(0).get<std::string>(), path("empty.png"));
  EXPECT_NEAR(run.number("fx"), RenderedCamera{}.fx, 4);
}

TEST_F(LabCalibrateTarget, BadInputIsRefusedWithWhatToDo) {
  refused(board(0), 1, "at least 3 are needed");
  refused(board(0) + " " + board(1) + " " + board(2) + " --board 7x5", 1, "was found in 0 of 3 pictures");
  refused(board(0) + " --board 9", 2, "expected the inner corners");
  refused(board(0) + " --board 9x6x2", 2, "expected the inner corners");
  refused(path("none.png"), 1, "none.png");
  write("noise.png", "no picture");
  refused(path("noise.png"), 1, "noise.png");
  RenderedCamera small{.width = 600};
  std::string mixed = board(0) + " " + board(1);
  refused(mixed + " " + board(2, small), 1, "600x480");
}

TEST_F(LabCalibrateTarget, PicturesFromOneDirectionAreNotEnough) {
  std::string pictures;
  for (int i = 0; i < 4; ++i) {
    const std::string file = path("same-" + std::to_string(i) + ".png");
    render({}, {0.02, 0.01 * i, 0.3 * i}, {0.01 * i, 0, 0.45}, file);
    pictures += file + " ";
  }
  refused(pictures, 1, "from several directions");
}

class LabCalibrateCharuco : public LabCalibrateTarget {
 protected:
  void SetUp() override {
    LabCalibrateTarget::SetUp();
    if (!charuco_pattern(columns, rows, "5X5_100", 40)) GTEST_SKIP() << "this build has no ArUco";
  }
  /// Pictures from so near that no picture has the whole board; names begin with the dictionary's.
  std::string pictures(std::size_t count, const std::string& dictionary = "5X5_100") const {
    constexpr int px = 80;
    const host::Raster<std::uint8_t> drawn = *charuco_pattern(columns, rows, dictionary, px);
    const Pattern pattern = [&](double column, double row) {
      if (column < -2 || row < -2 || column >= columns + 1 || row >= rows + 1) return 110;
      const int x = static_cast<int>(std::floor((column + 1) * px)), y = static_cast<int>(std::floor((row + 1) * px));
      const bool on_board = x >= 0 && y >= 0 && x < drawn.width && y < drawn.height;
      return on_board && drawn.at(x, y) < 128 ? 25 : 225;
    };
    std::string names;
    for (std::size_t i = 0; i < count; ++i) {
      const std::array<double, 6>& p = poses.at(i);
      const std::string file = path(dictionary + "-" + std::to_string(i) + ".png");
      render({}, {p[0], p[1], p[2]}, {p[3], p[4], 0.7 * p[5]}, file, pattern);
      names += file + " ";
    }
    return names;
  }
};

TEST_F(LabCalibrateCharuco, FindsTheCameraOfBoardsThatAreSeenInPart) {
  const LabRun run = lab_done("calibrate-target " + pictures(poses.size()) + "--board 9x6 --charuco 5x5_100 --out " +
                              path("camera.txt") + " --picture " + path("residuals.svg"));
  EXPECT_EQ(run.json.at("pictures").size(), poses.size()) << run.out;
  EXPECT_LT(run.number("rms_px"), 0.2);
  std::size_t in_part = 0;
  for (const auto& picture : run.json.at("pictures")) in_part += picture.at("corners").get<int>() < columns * rows;
  EXPECT_GE(in_part, 6U) << run.out;
  EXPECT_GT(run.number("coverage"), 0.7);
  // Corners that are interpolated between markers are less exact than a chessboard's.
  expect_camera({}, 1.2);
  EXPECT_TRUE(std::filesystem::exists(path("residuals.svg")));
}

TEST_F(LabCalibrateCharuco, AWrongBoardIsRefusedWithWhatToDo) {
  const std::string seen = pictures(3);
  refused(seen + "--charuco 5X5_7", 2, "5X5_50, 5X5_100, 5X5_250");
  refused(seen + "--charuco 4X4_50 --board 9x6", 1, "5X5_50: give --charuco 5X5_50");
  refused(seen + "--charuco 5X5_100 --board 6x6", 1, "marker ");
  refused(seen + "--charuco 5X5_100 --board 11x6", 1, "lie otherwise than on a board of 11x6 inner corners");
  refused(seen + "--charuco 5X5_100 --board 6x9", 1, "lie otherwise than on a board of 6x9 inner corners");
  refused(seen + "--charuco 5X5_50 --board 12x9", 1, "50 markers, fewer than the 65 white squares");
  refused(seen + "--charuco 5X5_100 --marker 1", 2, "--marker");
  refused(grey("empty.png", 640, 480) + " --charuco 5X5_100", 1, "at least six inner corners");
}

}  // namespace
}  // namespace ilp::test
