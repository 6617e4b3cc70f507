// ilp-lab on input made up here, so that the right answer is known.

#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <random>
#include <sstream>

#include "sim/host/image_io.hpp"
#include "tests/integration/lab_program.hpp"
#include "tests/support/strip.hpp"

namespace ilp::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;

class LabGenerated : public LabTest {
 protected:
  /// The endless landscape from pixel (x0, y0) on.
  std::string write_window(const std::string& name, double x0, double y0, int width = 320, int height = 240) const {
    host::Raster<std::uint8_t> image(width, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        image.at(x, y) = static_cast<std::uint8_t>(std::clamp(fractal_texture(x0 + x, y0 + y, 2, 5), 0.0, 255.0));
      }
    }
    host::write_pgm(path(name), image.view());
    return path(name);
  }
  /// A camera at the origin that looks along z at fifty points, and a second one with this pose (qw qx qy qz tx ty tz).
  LabRun rectify_with_second_pose(const std::string& pose) const {
    write("cameras.txt", pinhole_text(320, 240, 300, 159.5, 119.5));
    write("images.txt", "1 1 0 0 0 0 0 0 1 a.pgm\n\n2 " + pose + " 1 b.pgm\n\n");
    std::ostringstream points;
    for (int i = 0; i < 50; ++i) points << i << " " << 0.05 * (i % 10) << " " << 0.04 * (i % 7) << " 2 0 0 0 0\n";
    write("points3D.txt", points.str());
    return lab("rectify " + write_window("a.pgm", 0, 0) + " " + write_window("b.pgm", 0, 0) + " --model " + path("") +
               " --out " + path("rect"));
  }
};

TEST_F(LabGenerated, OverlapOfAShiftedWindow) {
  // A PNG and a PGM: the same program takes both.
  const std::string a = write_window("a.pgm", 0, 0), b = path("b.png");
  host::write_png(b, host::read_gray(write_window("b.pgm", 60, 24)).view());
  for (const char* method : {"ncc", "sad"}) {
    const LabRun run = lab_done("overlap " + a + " " + b + " --method " + method);
    EXPECT_EQ(run.verdict(), "ok");
    EXPECT_NEAR(run.number("overlap"), (320 - 60) * (240 - 24) / (320.0 * 240.0), 0.005);
    EXPECT_NEAR(run.json["shift_px"][0].get<double>(), -60, 1);
    EXPECT_NEAR(run.json["shift_px"][1].get<double>(), -24, 1);
    EXPECT_NEAR(run.number("scale"), 1, 0.01);
    EXPECT_GT(run.number("kernel_ms"), 0);
  }
}

TEST_F(LabGenerated, UnrelatedImagesAreAVerdictNotAnError) {
  const LabRun run = lab_done("overlap " + write_window("a.pgm", 0, 0) + " " + write_window("b.pgm", 5000, 9000));
  EXPECT_EQ(run.verdict(), "overlap_unknown");
}

TEST_F(LabGenerated, MatchesOfAShiftedWindow) {
  const std::string a = write_window("a.pgm", 0, 0), b = write_window("b.pgm", 40.5, -10.25);
  const LabRun run = lab_done("match " + a + " " + b + " --corners 300 --out " + path("m.txt"));
  const auto lines = read_numbers(path("m.txt"));
  ASSERT_EQ(lines.size(), run.json["matches"].get<std::size_t>());
  EXPECT_GT(lines.size(), 100U);
  EXPECT_LE(run.number("corners_a"), 300);
  std::size_t right = 0;
  for (const auto& m : lines) {
    ASSERT_EQ(m.size(), 5U);
    right += std::hypot(m[2] - m[0] + 40.5, m[3] - m[1] - 10.25) < 0.3 ? 1 : 0;
  }
  EXPECT_GT(static_cast<double>(right), 0.97 * static_cast<double>(lines.size()));
}

/// Brown's distortion, from its formula.
Vector2d distorted(const Vector2d& p, double k1, double k2, double p1, double p2) {
  const double r2 = p.squaredNorm(), radial = 1 + k1 * r2 + k2 * r2 * r2;
  return {p.x() * radial + 2 * p1 * p.x() * p.y() + p2 * (r2 + 2 * p.x() * p.x()),
          p.y() * radial + p1 * (r2 + 2 * p.y() * p.y()) + 2 * p2 * p.x() * p.y()};
}

TEST_F(LabGenerated, RelativePoseOfTwoDifferentDistortedCameras) {
  const std::string camera_a = write("a.txt", "1 OPENCV 640 480 500 510 320 240 -0.1 0.02 0.001 -0.002\n");
  const std::string camera_b = write("b.txt", "1 PINHOLE 640 480 620 620 330 235\n");
  const Matrix3d rotation = Eigen::AngleAxisd(0.15, Vector3d(0.3, -0.5, 0.8).normalized()).toRotationMatrix();
  const Vector3d translation = Vector3d(-0.9, 0.2, 0.3).normalized() * 0.25;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> wide(-0.5, 0.5), deep(0.8, 1.5), anywhere(10, 460);
  std::normal_distribution<double> noise(0, 0.2);
  std::ostringstream matches;
  matches.precision(12);
  for (int i = 0; i < 400; ++i) {
    const double depth = deep(random);
    const Vector3d in_a(wide(random) * depth, 0.8 * wide(random) * depth, depth);
    const Vector3d in_b = rotation * in_a + translation;
    const Vector2d a = distorted(in_a.hnormalized(), -0.1, 0.02, 0.001, -0.002), b = in_b.hnormalized();
    double xb = 620 * b.x() + 329.5 + noise(random), yb = 620 * b.y() + 234.5 + noise(random);
    if (i % 4 == 0) {
      xb = anywhere(random);
      yb = anywhere(random);
    }
    matches << 500 * a.x() + 319.5 + noise(random) << " " << 510 * a.y() + 239.5 + noise(random) << " " << xb << " "
            << yb << (i % 2 == 0 ? " 0.5" : "") << "\n";
  }
  const LabRun run = lab_done("relpose " + write("m.txt", matches.str()) + " --camera " + camera_a + " --camera-b " +
                              camera_b + " --seed 3 --repeat 3");
  EXPECT_EQ(run.verdict(), "ok");
  const auto q = run.json["rotation_b_from_a"].get<std::vector<double>>();
  const auto t = run.json["direction_b"].get<std::vector<double>>();
  EXPECT_LT(Quaterniond(q[0], q[1], q[2], q[3]).angularDistance(Quaterniond(rotation)), 0.002);
  EXPECT_GT(Vector3d(t[0], t[1], t[2]).dot(translation.normalized()), std::cos(0.02));
  EXPECT_NEAR(run.number("inliers"), 300, 12);
  EXPECT_LT(run.number("gric_e"), run.number("gric_h"));
  EXPECT_GT(run.number("median_parallax_px"), 20);
}

TEST_F(LabGenerated, HomographyRowByRow) {
  Matrix3d truth;
  truth << 1.02, -0.05, 12, 0.04, 0.98, -7, 2e-5, -4e-5, 1;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> anywhere(0, 600);
  std::ostringstream matches;
  matches.precision(12);
  for (int i = 0; i < 200; ++i) {
    const Vector2d a(anywhere(random), anywhere(random));
    const Vector2d b =
        i % 5 == 0 ? Vector2d(anywhere(random), anywhere(random)) : Vector2d((truth * a.homogeneous()).hnormalized());
    matches << a.x() << " " << a.y() << " " << b.x() << " " << b.y() << "\n";
  }
  const std::string list = write("m.txt", matches.str());
  const LabRun run = lab_done("homography " + list);
  EXPECT_EQ(run.verdict(), "ok");
  EXPECT_NEAR(run.number("inliers"), 160, 2);
  const auto rows = run.json["homography"].get<std::vector<std::vector<double>>>();
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) {
      const double expected = truth(static_cast<int>(r), static_cast<int>(c));
      EXPECT_NEAR(rows[r][c] / rows[2][2], expected, 1e-6 * (1 + std::fabs(expected)));
    }
  }
}

TEST_F(LabGenerated, FundamentalMatrixHoldsItsInliers) {
  const Matrix3d rotation = Eigen::AngleAxisd(0.1, Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  std::mt19937 random(11);
  std::uniform_real_distribution<double> wide(-0.4, 0.4), deep(0.7, 1.5);
  std::ostringstream matches;
  matches.precision(14);
  std::vector<std::array<Vector2d, 2>> pairs;
  for (int i = 0; i < 150; ++i) {
    const double depth = deep(random);
    const Vector3d in_a(wide(random) * depth, wide(random) * depth, depth);
    const Vector3d in_b = rotation * in_a + Vector3d(0.2, 0.05, 0.02);
    const Vector2d a = 500 * in_a.hnormalized() + Vector2d(300, 200), b = 500 * in_b.hnormalized() + Vector2d(310, 190);
    pairs.push_back({a, b});
    matches << a.x() << " " << a.y() << " " << b.x() << " " << b.y() << "\n";
  }
  const LabRun run = lab_done("fundamental " + write("m.txt", matches.str()));
  EXPECT_EQ(run.verdict(), "ok");
  const auto rows = run.json["fundamental"].get<std::vector<std::vector<double>>>();
  Matrix3d f;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) f(r, c) = rows[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)];
  }
  for (const auto& [a, b] : pairs) {
    const Vector3d line = f * a.homogeneous();
    EXPECT_LT(std::fabs(b.homogeneous().dot(line)) / line.head<2>().norm(), 0.01);
  }
}

struct Window {
  std::vector<std::vector<double>> observations, cameras, points;
};

Vector2d project(const std::vector<double>& camera, const std::vector<double>& point) {
  const Vector3d r(camera[1], camera[2], camera[3]), t(camera[4], camera[5], camera[6]);
  const double angle = r.norm();
  const Matrix3d rotation =
      angle > 0 ? Eigen::AngleAxisd(angle, r / angle).toRotationMatrix() : Matrix3d(Matrix3d::Identity());
  return 700 * (rotation * Vector3d(point[0], point[1], point[2]) + t).hnormalized() + Vector2d(320, 240);
}

double cost_of(const Window& window) {
  double squares = 0;
  for (const auto& o : window.observations) {
    const Vector2d projected =
        project(window.cameras[static_cast<std::size_t>(o[0])], window.points[static_cast<std::size_t>(o[1])]);
    squares += (projected - Vector2d(o[2], o[3])).squaredNorm();
  }
  return squares / 2;
}

std::string text_of(const Window& window) {
  std::ostringstream text;
  text.precision(15);
  text << "# a window\n" << window.cameras.size() << " " << window.points.size() << " " << window.observations.size();
  text << "\n700 700 320 240\n";
  for (const auto* block : {&window.observations, &window.cameras, &window.points}) {
    for (const auto& line : *block) {
      for (std::size_t i = 0; i < line.size(); ++i) text << (i > 0 ? " " : "") << line[i];
      text << "\n";
    }
  }
  return text.str();
}

constexpr double window_noise_px = 0.3;

/// Five cameras over points at distance one, the first two fixed at their true poses, all else disturbed.
Window disturbed_window() {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 1);
  std::uniform_real_distribution<double> wide(-0.4, 0.4), deep(0.9, 1.1);
  Window window;
  for (int c = 0; c < 5; ++c) {
    window.cameras.push_back({c < 2 ? 1.0 : 0.0, 0.02 * c, -0.01 * c, 0.05 * c, -0.1 * c, 0.01 * c, 0.005 * c});
  }
  for (int p = 0; p < 300; ++p) window.points.push_back({wide(random) + 0.2, wide(random), deep(random)});
  for (int c = 0; c < 5; ++c) {
    for (int p = 0; p < 300; ++p) {
      const Vector2d seen =
          project(window.cameras[static_cast<std::size_t>(c)], window.points[static_cast<std::size_t>(p)]);
      window.observations.push_back(
          {1.0 * c, 1.0 * p, seen.x() + window_noise_px * noise(random), seen.y() + window_noise_px * noise(random)});
    }
  }
  for (std::size_t c = 2; c < 5; ++c) {
    for (std::size_t i = 1; i < 7; ++i) window.cameras[c][i] += 0.003 * noise(random);
  }
  for (auto& point : window.points) {
    for (double& x : point) x += 0.003 * noise(random);
  }
  return window;
}

TEST_F(LabGenerated, BundleReachesTheNoiseAndItsResultFileSaysTheSame) {
  const Window before = disturbed_window();
  const LabRun run = lab_done("bundle " + write("w.txt", text_of(before)) + " --out " + path("r.txt") + " --repeat 2");
  EXPECT_EQ(run.verdict(), "ok");

  const auto lines = read_numbers(path("r.txt"));
  ASSERT_EQ(lines.size(), 2 + 1500 + 5 + 300U);
  EXPECT_EQ(lines[0], (std::vector<double>{5, 300, 1500}));
  EXPECT_EQ(lines[1], (std::vector<double>{700, 700, 320, 240}));
  const Window after{{lines.begin() + 2, lines.begin() + 1502},
                     {lines.begin() + 1502, lines.begin() + 1507},
                     {lines.begin() + 1507, lines.end()}};
  EXPECT_NEAR(run.number("initial_cost"), cost_of(before), 1e-6 * cost_of(before));
  EXPECT_NEAR(run.number("cost"), cost_of(after), 1e-6 * cost_of(after));
  for (std::size_t c = 0; c < 2; ++c) {
    for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR(after.cameras[c][i], before.cameras[c][i], 1e-12);
  }
  // Expected: variance times residuals left after fitting the unknowns.
  const double freedom = 2 * 1500 - 3 * 300 - 6 * 3;
  EXPECT_NEAR(2 * run.number("cost") / freedom, window_noise_px * window_noise_px, 0.01);
  EXPECT_NEAR(run.number("final_rms_px"), std::sqrt(2 * run.number("cost") / 3000), 1e-6);
  EXPECT_GT(run.number("initial_rms_px"), 2);
}

TEST_F(LabGenerated, BundleTakesItsOwnResult) {
  const std::string out = path("r.txt");
  ASSERT_EQ(lab("bundle " + write("w.txt", text_of(disturbed_window())) + " --out " + out).status, 0);
  const LabRun again = lab_done("bundle " + out + " --robust 2 --out " + path("rr.txt"));
  EXPECT_LE(again.number("iterations"), 3);
}

TEST_F(LabGenerated, StereoGivesTheShiftAndMarksWhatItCannotSee) {
  const std::string left = write_window("l.pgm", 0, 0), right = write_window("r.pgm", 9, 0);
  const LabRun run = lab_done("stereo " + left + " " + right + " --min-disparity -4 --max-disparity 27 --out " +
                              path("d.pfm") + " --sigma " + path("s.pfm"));
  const host::Raster<float> disparity = host::read_pfm(path("d.pfm")), sigma = host::read_pfm(path("s.pfm"));
  ASSERT_EQ(disparity.width, 320);
  std::size_t right_ones = 0, valid = 0;
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      const float d = disparity.at(x, y);
      ASSERT_EQ(std::isfinite(d), std::isfinite(sigma.at(x, y)));
      if (!std::isfinite(d)) {
        ASSERT_GT(d, 0) << "invalid is +infinity";
        continue;
      }
      ++valid;
      right_ones += std::fabs(d - 9) < 0.25F ? 1 : 0;
    }
  }
  EXPECT_EQ(valid, run.json["valid_pixels"].get<std::size_t>());
  EXPECT_NEAR(run.number("valid"), static_cast<double>(valid) / (320 * 240), 1e-9);
  EXPECT_GT(run.number("valid"), 0.85);
  EXPECT_GT(static_cast<double>(right_ones), 0.98 * static_cast<double>(valid));
  EXPECT_NEAR(run.number("mega_disparities_per_s"), 320 * 240 * 32 / (1000 * run.number("kernel_ms")), 0.01);
}

/// The true disparity is 9 px.
TEST_F(LabGenerated, StereoSaysThatARangeHoldsNoMatches) {
  const std::string left = write_window("l.pgm", 0, 0), right = write_window("r.pgm", 9, 0);
  const auto run = [&](const char* range) {
    return lab("stereo " + left + " " + right + range + " --out " + path("d.pfm"));
  };
  for (const char* range : {" --min-disparity 14 --max-disparity 45", " --min-disparity=-40 --max-disparity 3",
                            " --min-disparity=-90 --max-disparity=-60"}) {
    const LabRun wrong = run(range);
    ASSERT_EQ(wrong.status, 0) << wrong.err;
    EXPECT_EQ(wrong.json["verdict"], "too_few_valid") << range << wrong.json;
    EXPECT_NE(wrong.err.find("the range is wrong"), std::string::npos) << wrong.err;
  }
  for (const char* range : {" --min-disparity 5 --max-disparity 12", " --min-disparity=-20 --max-disparity 60"}) {
    const LabRun right_one = run(range);
    EXPECT_EQ(right_one.json["verdict"], "ok") << range << right_one.json;
    EXPECT_EQ(right_one.err, "") << right_one.err;
  }
}

/// The upper half of the right image is shifted by 9 px, the lower one by 25 px.
TEST_F(LabGenerated, StereoSaysThatARangeHoldsAPartOfTheGround) {
  const std::string left = write_window("l.pgm", 0, 0), right = write_window("r.pgm", 9, 0);
  host::Raster<std::uint8_t> both = host::read_gray(right);
  const host::Raster<std::uint8_t> lower = host::read_gray(write_window("lower.pgm", 25, 0));
  std::copy(lower.samples.begin() + 320 * 120, lower.samples.end(), both.samples.begin() + 320 * 120);
  host::write_pgm(right, both.view());
  const struct {
    const char* range;
    const char* verdict;
    double below, above;
  } cases[] = {{" --min-disparity 0 --max-disparity 31", "ok", 0, 0},
               {" --min-disparity 0 --max-disparity 16", "range_too_small", 0, 0.45},
               {" --min-disparity 16 --max-disparity 40", "range_too_small", 0.45, 0}};
  for (const auto& one : cases) {
    const LabRun run = lab_done("stereo " + left + " " + right + one.range + " --out " + path("d.pfm"));
    EXPECT_EQ(run.json["verdict"], one.verdict) << one.range << run.json;
    EXPECT_NEAR(run.number("below"), one.below, 0.06) << one.range;
    EXPECT_NEAR(run.number("above"), one.above, 0.06) << one.range;
    EXPECT_EQ(run.err.find("widen the range") != std::string::npos, one.below + one.above > 0) << run.err;
  }
  const LabRun all =
      lab("stereo " + left + " " + right + " --min-disparity=-100 --max-disparity 155 --out " + path("d.pfm"));
  EXPECT_TRUE(all.json["below"].is_null()) << "there are no more disparities to search: " << all.json;
}

TEST_F(LabGenerated, EncodedFileFitsAndOpens) {
  const std::string image = write_window("i.pgm", 0, 0);
  host::Raster<std::uint8_t> mask(320, 240);
  for (int y = 60; y < 180; ++y) {
    for (int x = 80; x < 240; ++x) mask.at(x, y) = 255;
  }
  host::write_png(path("m.png"), mask.view());
  const LabRun run =
      lab_done("encode " + image + " --mask " + path("m.png") + " --bpp 0.8 --layers 3 --out " + path("x.jp2"));
  const auto bytes = std::filesystem::file_size(path("x.jp2"));
  EXPECT_EQ(bytes, run.json["bytes"].get<std::uintmax_t>());
  EXPECT_LE(static_cast<double>(bytes), 0.8 * 320 * 240 / 8);
  EXPECT_GT(run.number("psnr_inside_db"), run.number("psnr_outside_db") + 6);

  if (std::system("command -v opj_decompress >/dev/null") != 0) GTEST_SKIP() << "opj_decompress is not installed";
  const std::string decode = "opj_decompress -i " + path("x.jp2") + " -o " + path("x.pgm") + " >/dev/null 2>&1";
  ASSERT_EQ(std::system(decode.c_str()), 0);
  const host::Raster<std::uint8_t> original = host::read_gray(image), decoded = host::read_gray(path("x.pgm"));
  double squares = 0;
  for (int y = 60; y < 180; ++y) {
    for (int x = 80; x < 240; ++x) squares += std::pow(double(original.at(x, y)) - double(decoded.at(x, y)), 2);
  }
  EXPECT_NEAR(10 * std::log10(255 * 255 * 120 * 160 / squares), run.number("psnr_inside_db"), 0.05);
}

TEST_F(LabGenerated, LosslessIsExactAndTooFewBytesAreAVerdict) {
  const std::string image = write_window("i.pgm", 0, 0);
  const LabRun exact = lab_done("encode " + image + " --lossless --out " + path("x.jp2"));
  EXPECT_TRUE(exact.json["exact_inside"].get<bool>());
  EXPECT_TRUE(exact.json["psnr_inside_db"].is_null());
  const LabRun poor = lab_done("encode " + image + " --lossless --bpp 0.5 --out " + path("y.jp2"));
  EXPECT_EQ(poor.verdict(), "grant_too_small");
  EXPECT_FALSE(std::filesystem::exists(path("y.jp2")));
}

TEST_F(LabGenerated, RichnessSeesTextureReliefAndMask) {
  const std::string image = write_window("i.pgm", 0, 0);
  host::Raster<std::uint8_t> flat(320, 240, 100), half(320, 240);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 320; ++x) half.at(x, y) = 1;
  }
  host::write_pgm(path("flat.pgm"), flat.view());
  host::write_pgm(path("half.pgm"), half.view());
  host::Raster<float> level(320, 240, 50.0F), rough(320, 240);
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) rough.at(x, y) = static_cast<float>(50 + 4 * std::sin(0.06 * x) * std::cos(0.05 * y));
  }
  host::write_pfm(path("level.pfm"), level.view());
  host::write_pfm(path("rough.pfm"), rough.view());

  const LabRun plain = lab_done("richness " + image), dull = lab("richness " + path("flat.pgm"));
  ASSERT_EQ(dull.status, 0) << dull.err;
  EXPECT_GT(plain.number("index"), dull.number("index") + 0.1);
  EXPECT_FALSE(plain.json["has_terrain"].get<bool>());
  const LabRun flat_ground = lab("richness " + image + " --depth " + path("level.pfm"));
  const LabRun hills = lab_done("richness " + image + " --depth " + path("rough.pfm") + " --mask " + path("half.pgm"));
  EXPECT_TRUE(hills.json["has_terrain"].get<bool>());
  EXPECT_NEAR(flat_ground.number("relief"), 0, 1e-3);
  EXPECT_NEAR(hills.number("relief"), 8.0 / 50, 0.04);
  EXPECT_NEAR(hills.number("mask_fraction"), 0.5, 1e-6);
}

/// Level ground at z = 0 under two cameras at height 1 that look down, slightly tilted and turned.
TEST_F(LabGenerated, RectifiedGroundMatchesRowByRow) {
  constexpr int width = 320, height = 240;
  constexpr double focal = 300;
  const Matrix3d down = Vector3d(1, -1, -1).asDiagonal();
  const Matrix3d tilt[] = {Eigen::AngleAxisd(0.05, Vector3d(1, 1, 0.5).normalized()).toRotationMatrix(),
                           Eigen::AngleAxisd(0.08, Vector3d(-1, 0.4, 1).normalized()).toRotationMatrix()};
  const Vector3d centre[] = {{0, 0, 1}, {0.2, 0.03, 1.02}};
  std::ostringstream images;
  images.precision(17);
  for (int i = 0; i < 2; ++i) {
    const Matrix3d rotation = tilt[i] * down;
    host::Raster<std::uint8_t> image(width, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const Vector3d ray = rotation.transpose() * Vector3d((x - 159.5) / focal, (y - 119.5) / focal, 1);
        const Vector3d ground = centre[i] - ray * (centre[i].z() / ray.z());
        const double grey = fractal_texture(focal * ground.x(), focal * ground.y(), 3, 9);
        image.at(x, y) = static_cast<std::uint8_t>(std::clamp(grey, 0.0, 255.0));
      }
    }
    host::write_png(path(i == 0 ? "a.png" : "b.png"), image.view());
    const Quaterniond q(rotation);
    const Vector3d t = -(rotation * centre[i]);
    images << i + 1 << " " << q.w() << " " << q.x() << " " << q.y() << " " << q.z() << " " << t.x() << " " << t.y()
           << " " << t.z() << " 1 " << (i == 0 ? "a.png" : "b.png") << "\n\n";
  }
  std::ostringstream points;
  for (int i = 0; i < 100; ++i)
    points << i << " " << 0.05 * (i % 10) - 0.2 << " " << 0.05 * (i / 10) - 0.2 << " 0 0 0 0 0\n";
  write("cameras.txt", pinhole_text(width, height, focal, 159.5, 119.5));
  write("images.txt", images.str());
  write("points3D.txt", points.str());
  const LabRun run =
      lab_done("rectify " + path("a.png") + " " + path("b.png") + " --model " + path("") + " --out " + path("rect"));
  EXPECT_EQ(run.json["method"], "homography");
  EXPECT_LT(run.number("max_vertical_error_px"), 1e-6);
  EXPECT_GT(run.number("points"), 30);

  // The ground is a plane, so are its disparities; where the matcher finds them, rows agree.
  const std::string range =
      " --min-disparity " + run.json["min_disparity"].dump() + " --max-disparity " + run.json["max_disparity"].dump();
  lab_done("stereo " + path("rect/left.png") + " " + path("rect/right.png") + range + " --out " + path("d.pfm"));
  const host::Raster<std::uint8_t> left = host::read_gray(path("rect/left.png")),
                                   right = host::read_gray(path("rect/right.png"));
  const host::Raster<std::uint8_t> inside = host::read_gray(path("rect/left_valid.png"));
  const host::Raster<float> disparity = host::read_pfm(path("d.pfm"));
  double difference = 0;
  std::size_t pixels = 0, matched = 0;
  for (int y = 0; y < left.height; ++y) {
    for (int x = 0; x < left.width; ++x) {
      if (inside.at(x, y) == 0) continue;
      ++pixels;
      const double xr = x - static_cast<double>(disparity.at(x, y));
      if (!(xr >= 0 && xr < left.width - 1)) continue;
      const int x0 = static_cast<int>(xr);
      const double grey = right.at(x0, y) + (xr - x0) * (right.at(x0 + 1, y) - right.at(x0, y));
      difference += std::fabs(grey - left.at(x, y));
      ++matched;
    }
  }
  EXPECT_GT(static_cast<double>(matched), 0.5 * static_cast<double>(pixels));
  EXPECT_LT(difference / static_cast<double>(matched), 3) << "grey levels";
}

TEST_F(LabGenerated, ForwardMotionIsRectifiedByPolarCoordinates) {
  const LabRun run = rectify_with_second_pose("1 0 0 0 0 0 -0.3");
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.verdict(), "ok");
  EXPECT_EQ(run.json["method"], "polar");
  EXPECT_LT(run.number("max_vertical_error_px"), 1e-6);
  EXPECT_GT(run.number("points"), 20);
  EXPECT_GT(run.number("blind_radius_px"), 0);
  ASSERT_TRUE(run.json.contains("panels"));
  for (const auto& panel : run.json["panels"]) {
    const host::Raster<std::uint8_t> left =
        host::read_gray(path("rect/" + panel["folder"].get<std::string>() + "/left.png"));
    EXPECT_EQ(left.width, panel["width"].get<std::int32_t>());
    EXPECT_EQ(left.height, panel["height"].get<std::int32_t>());
  }
}

TEST_F(LabGenerated, CamerasThatLookApartCannotBeRectified) {
  // The second one looks up at 90 degrees from the first.
  const LabRun run = rectify_with_second_pose("0.7071067811865476 0.7071067811865476 0 0 0.3 0 0");
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.verdict(), "rectification_impossible");
}

}  // namespace
}  // namespace ilp::test
