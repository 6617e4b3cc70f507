// Overlap, masks, heights and models of true frames against geometry that is done by hand.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <vector>

#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/overlap/overlap.hpp"
#include "sim/host/geo_raster.hpp"
#include "sim/host/image_io.hpp"
#include "sim/world/height_grid.hpp"
#include "sim/world/truth.hpp"
#include "sim/world/visibility.hpp"
#include "tests/unit/host/scratch_folder.hpp"

namespace ilp::world {
namespace {

const Mat3 nadir = Vec3(1, -1, -1).asDiagonal();  // image x along the world's x, image y along its -y

CameraModel camera_of(int width, int height) {
  return {width, height, 0.9 * width, 0.9 * width, 0.5 * (width - 1), 0.5 * (height - 1), 0, 0, 0, 0};
}

/// What stands in the way of a ray: level ground at z = 0 and a box on it.
struct Scene {
  Vec3 low = Vec3(0, 0, -2), high = Vec3(0, 0, -1);

  /// The smallest t > 0 at which origin + t * direction meets something.
  [[nodiscard]] double hit(const Vec3& origin, const Vec3& direction) const {
    const double ground = -origin.z() / direction.z();
    double enter = 0, leave = 1e300;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (low[axis] - origin[axis]) / direction[axis];
      const double b = (high[axis] - origin[axis]) / direction[axis];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    return high.z() > 0 && enter < leave ? std::min(enter, ground) : ground;
  }
};

host::Raster<float> depth_map(const Scene& scene, const CameraModel& camera, const Mat3& rotation, const Vec3& centre) {
  host::Raster<float> depth(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Vec2 n = normalised_from_pixel(camera, Vec2(x, y));
      depth.at(x, y) = static_cast<float>(scene.hit(centre, rotation.transpose() * Vec3(n.x(), n.y(), 1)));
    }
  }
  return depth;
}

TrueFrame frame_at(const CameraModel& camera, const Vec3& centre, int stride = 5, const Mat3& rotation = nadir,
                   const Scene& scene = {}) {
  return true_frame(camera, rotation, centre, depth_map(scene, camera, rotation, centre).view(), stride);
}

Mat3 turned(double about_x, double about_y, double about_z) {
  return rotation_from_vector(Vec3(about_x, 0, 0)) * rotation_from_vector(Vec3(0, about_y, 0)) *
         rotation_from_vector(Vec3(0, 0, about_z)) * nadir;
}

TEST(TrueOverlap, OfShiftedNadirViewsIsThatOfShiftedRectangles) {
  const CameraModel camera = camera_of(320, 241);
  const double pixel = 100 / camera.fx;
  const TrueFrame a = frame_at(camera, Vec3(3, 4, 100));
  for (const Vec2& shift : {Vec2(0, 0), Vec2(57.3, 0), Vec2(0, -40.7), Vec2(80.2, 33.1), Vec2(300, 0)}) {
    const TrueFrame b = frame_at(camera, a.centre + pixel * Vec3(shift.x(), shift.y(), 0));
    const double expected = (1 - std::fabs(shift.x()) / 320) * (1 - std::fabs(shift.y()) / 241);
    EXPECT_NEAR(true_overlap(a, b), expected, 1e-4) << shift.transpose();
    EXPECT_NEAR(true_footprint_overlap(a, b), expected, 1e-4) << shift.transpose();
  }
  EXPECT_EQ(true_overlap(a, frame_at(camera, a.centre + Vec3(300, 0, 0))), 0);
}

TEST(TrueOverlap, IsAShareOfTheFirstFramesArea) {
  const CameraModel camera = camera_of(320, 240);
  const TrueFrame low = frame_at(camera, Vec3(0, 0, 80));
  const TrueFrame high = frame_at(camera, Vec3(0, 0, 100));
  EXPECT_NEAR(true_overlap(low, high), 1, 1e-6);
  EXPECT_NEAR(true_overlap(high, low), 0.64, 1e-4);
}

TEST(TrueOverlap, AgreesWithThePolygonOfAPlaneUnderTurnAndTilt) {
  const CameraModel camera = camera_of(641, 480);
  const Mat3 rotation_a = turned(0.03, -0.06, 0.1);
  const Vec3 centre_a(0, 0, 100);
  const TrueFrame a = frame_at(camera, centre_a, sample_stride(camera), rotation_a);
  Mat3 k;
  k << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  for (const double turn : {0.0, 0.1, -0.35}) {
    for (const double tilt : {0.0, 0.08}) {
      const Mat3 rotation_b = turned(-tilt, tilt, turn);
      const Vec3 centre_b(18, 7, 104);
      // Homography of the plane n X = -100 in a's coordinates, n = rotation_a z.
      const Mat3 b_from_a = rotation_b * rotation_a.transpose();
      const Vec3 shift = rotation_b * (centre_a - centre_b), normal = rotation_a * Vec3(0, 0, 1);
      const Mat3 h = k * (b_from_a - shift * normal.transpose() / 100) * k.inverse();
      const double rows[9] = {h(0, 0), h(0, 1), h(0, 2), h(1, 0), h(1, 1), h(1, 2), h(2, 0), h(2, 1), h(2, 2)};
      const TrueFrame b = frame_at(camera, centre_b, sample_stride(camera), rotation_b);
      EXPECT_NEAR(true_overlap(a, b), footprint_overlap_of_plane(camera.width, camera.height, rows), 0.002)
          << "turn " << turn << ", tilt " << tilt;
    }
  }
}

TEST(TrueOverlap, GroundBehindABoxIsNotSeenAgain) {
  const CameraModel camera = camera_of(241, 181);
  const Scene scene{Vec3(10, -15, 0), Vec3(20, 15, 30)};
  const Vec3 centre_a(0, 0, 100), centre_b(45, 3, 105);
  const TrueFrame a = frame_at(camera, centre_a, 1, nadir, scene);
  const TrueFrame b = frame_at(camera, centre_b, 1, nadir, scene);
  const host::Raster<std::uint8_t> mask = newly_seen_mask(a, &b, {});
  int wrong = 0, hidden = 0, seen = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Vec3 point = a.ground[a.index(x, y)];
      Vec2 pixel;
      double depth = 0;
      const bool in_image = project(b, point, pixel, depth);
      const bool visible = in_image && scene.hit(centre_b, point - centre_b) > 1 - 1e-4;
      hidden += in_image && !visible ? 1 : 0;
      seen += visible ? 1 : 0;
      wrong += visible != (mask.at(x, y) == 255) ? 1 : 0;
    }
  }
  EXPECT_GT(hidden, 400);         // the box's side and the ground behind it
  EXPECT_LT(wrong, hidden / 10);  // outlines, one pixel wide
  const double pixels = 241.0 * 181.0;
  EXPECT_NEAR(true_overlap(a, b), seen / pixels, 0.003);
  EXPECT_NEAR(true_footprint_overlap(a, b), (seen + hidden) / pixels, 0.003);
}

TEST(TrueMasks, VisibleBeforeIsWhatAnyEarlierFrameSaw) {
  const CameraModel camera = camera_of(160, 120);
  const double pixel = 100 / camera.fx;
  const auto at = [&](double x_px, double y_px) {
    return frame_at(camera, pixel * Vec3(x_px, y_px, 0) + Vec3(0, 0, 100), 5);
  };
  const TrueFrame left = at(-50.3, 0), below = at(10.2, -70.4), far = at(900, 0);
  const TrueFrame frame = frame_at(camera, Vec3(0, 0, 100), 1);
  const std::array<const TrueFrame*, 3> earlier{&far, &left, &below};
  const host::Raster<std::uint8_t> mask = visible_before_mask(frame, earlier);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      const bool in_left = x + 50.3 <= 159.5;
      const bool in_below = x - 10.2 >= -0.5 && y - 70.4 >= -0.5;  // image y runs along -y
      ASSERT_EQ(mask.at(x, y) == 255, in_left || in_below) << x << "," << y;
    }
  }
}

TEST(TrueMasks, NewlySeenIsThePairWithoutWhatEarlierPairsReconstructed) {
  const CameraModel camera = camera_of(160, 120);
  const double pixel = 100 / camera.fx;
  // Positions along x in pixels; the third goes back, so that ground returns into view.
  const std::vector<double> at{0, 40.3, 20.6, 75.1};
  std::vector<TrueFrame> frames;
  for (const double x : at) frames.push_back(frame_at(camera, Vec3(pixel * x, 0, 100), 1));
  const auto in = [&](std::size_t k, double x) { return x >= at[k] - 80 && x <= at[k] + 80; };
  std::vector<FramePair> earlier;
  for (std::size_t k = 0; k < at.size(); ++k) {
    const TrueFrame* partner = k + 1 < at.size() ? &frames[k + 1] : nullptr;
    const host::Raster<std::uint8_t> mask = newly_seen_mask(frames[k], partner, earlier);
    for (int column = 0; column < 160; ++column) {
      const double x = at[k] - 79.5 + column;
      bool expected = partner == nullptr || in(k + 1, x);
      for (std::size_t i = 0; i < k; ++i) expected = expected && !(in(i, x) && in(i + 1, x));
      ASSERT_EQ(mask.at(column, 60) == 255, expected) << "frame " << k << ", column " << column;
    }
    if (partner != nullptr) earlier.push_back({&frames[k], partner});
  }
}

double hill(double x, double y) {
  return 5 * std::sin(0.05 * x) * std::cos(0.04 * y);
}

host::Raster<float> hill_depth(const CameraModel& camera, const CameraState& state) {
  host::Raster<float> depth(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Vec2 n = normalised_from_pixel(camera, Vec2(x, y));
      const Vec3 direction = state.rotation.transpose() * Vec3(n.x(), n.y(), 1);
      double z = 100;
      for (int i = 0; i < 60; ++i) {
        const Vec3 p = state.centre + z * direction;
        z += (p.z() - hill(p.x(), p.y())) / -direction.z();
      }
      depth.at(x, y) = static_cast<float>(z);
    }
  }
  return depth;
}

TruthSource hill_flight(const std::filesystem::path& dir) {
  TruthSource source{.camera = camera_of(160, 120)};
  source.camera.k1 = -0.1;
  source.camera.p1 = 0.001;
  source.heights = [](double x0, double y, double spacing, std::span<double> height) {
    for (std::size_t i = 0; i < height.size(); ++i) height[i] = hill(x0 + spacing * static_cast<double>(i), y);
  };
  std::filesystem::create_directories(dir / "depth");
  for (int k = 0; k < 6; ++k) {
    CameraState state{.rotation = turned(0.02 * k, -0.03, 0.05 * k), .centre = Vec3(15 * k, 2 * k, 100 + k)};
    source.states.push_back(state);
    source.names.push_back("000" + std::to_string(k + 1) + ".pgm");
    host::write_pfm(dir / "depth" / ("000" + std::to_string(k + 1) + ".pfm"), hill_depth(source.camera, state).view());
  }
  return source;
}

std::vector<std::vector<std::string>> words_of(const std::filesystem::path& path, char separator) {
  std::ifstream in(path);
  std::vector<std::vector<std::string>> lines;
  for (std::string line; std::getline(in, line);) {
    if (!line.empty() && line[0] == '#') continue;
    std::istringstream words(line);
    lines.emplace_back();
    for (std::string word; std::getline(words, word, separator);) lines.back().push_back(word);
  }
  return lines;
}

TEST(WriteTruth, HeightsAreThoseOfTheGroundWhereverAFrameSeesIt) {
  const test::ScratchFolder folder;
  const TruthSource source = hill_flight(folder.path());
  write_truth(folder.path(), source);
  const HeightGrid grid = read_height_grid(folder.path());
  EXPECT_NEAR(grid.cell, 100 / source.camera.fx, 0.05);
  for (int j = 0; j < grid.height_m.height; ++j) {
    for (int i = 0; i < grid.height_m.width; ++i) {
      const float z = grid.height_m.at(i, j);
      if (std::isfinite(z)) {
        ASSERT_NEAR(z, hill(grid.x0 + i * grid.cell, grid.y0 - j * grid.cell), 1e-5) << i << "," << j;
      }
    }
  }
  const host::GeoRaster tiff = host::read_raster(folder / "height.tif");
  ASSERT_TRUE(tiff.place.has_value());
  EXPECT_NEAR(tiff.place->x, grid.x0, 1e-9);
  EXPECT_NEAR(tiff.place->y, grid.y0, 1e-9);
  EXPECT_NEAR(tiff.place->spacing_y, grid.cell, 1e-12);
  for (std::size_t i = 0; i < tiff.values.samples.size(); ++i) {
    const float z = grid.height_m.samples[i];
    ASSERT_TRUE(std::isfinite(z) ? tiff.values.samples[i] == z : std::isnan(tiff.values.samples[i])) << i;
  }
  int inside = 0, missing = 0;
  for (std::size_t k = 0; k < source.states.size(); ++k) {
    const host::Raster<float> depth = host::read_pfm(folder / "depth" / ("000" + std::to_string(k + 1) + ".pfm"));
    for (int y = 3; y < 117; y += 6) {
      for (int x = 3; x < 157; x += 6) {
        const Vec2 n = normalised_from_pixel(source.camera, Vec2(x, y));
        const CameraState& state = source.states[k];
        const Vec3 p = state.centre + state.rotation.transpose() * (depth.at(x, y) * Vec3(n.x(), n.y(), 1));
        const double height = height_at(grid, p.x(), p.y());
        ++inside;
        missing += std::isfinite(height) ? 0 : 1;
        if (std::isfinite(height)) {
          ASSERT_NEAR(height, p.z(), 0.01);
        }
      }
    }
  }
  EXPECT_LT(missing, inside / 100);
}

TEST(WriteTruth, OverlapsAndMasksBelongToEachOther) {
  const test::ScratchFolder folder;
  const TruthSource source = hill_flight(folder.path());
  write_truth(folder.path(), source);
  const auto lines = words_of(folder / "overlap.csv", ',');
  ASSERT_EQ(lines.at(0), (std::vector<std::string>{"frame_a", "frame_b", "overlap", "footprint"}));
  std::map<std::string, double> overlap;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    overlap[lines[i].at(0) + ">" + lines[i].at(1)] = std::stod(lines[i].at(2));
    EXPECT_GT(std::stod(lines[i][2]), 0.05);
    EXPECT_NEAR(std::stod(lines[i][2]), std::stod(lines[i].at(3)), 0.01);  // nothing of this ground is hidden
  }
  // The second frame has one before it: what it has seen before is what overlaps.
  const host::Raster<std::uint8_t> mask = host::read_gray(folder / "visible-before" / "0002.png");
  const auto seen = std::count(mask.samples.begin(), mask.samples.end(), 255);
  EXPECT_NEAR(overlap.at("0002>0001"), static_cast<double>(seen) / (160.0 * 120.0), 0.005);
  EXPECT_GT(overlap.at("0002>0001"), 0.7);
  EXPECT_LT(overlap.at("0001>0005"), overlap.at("0001>0004"));
  const host::Raster<std::uint8_t> first = host::read_gray(folder / "visible-before" / "0001.png");
  EXPECT_EQ(std::count(first.samples.begin(), first.samples.end(), 0), 160 * 120);
}

/// COLMAP's OPENCV model, written from its documentation; pixel centres at 0.5.
Vec2 opencv_pixel(const std::vector<std::string>& camera, const Vec3& p) {
  std::array<double, 8> c{};
  for (std::size_t i = 0; i < 8; ++i) c[i] = std::stod(camera.at(4 + i));
  const double x = p.x() / p.z(), y = p.y() / p.z(), r2 = x * x + y * y, radial = 1 + c[4] * r2 + c[5] * r2 * r2;
  return {c[0] * (x * radial + 2 * c[6] * x * y + c[7] * (r2 + 2 * x * x)) + c[2],
          c[1] * (y * radial + c[6] * (r2 + 2 * y * y) + 2 * c[7] * x * y) + c[3]};
}

TEST(WriteTruth, ColmapModelReprojectsExactlyAndItsPointsLieOnTheGround) {
  const test::ScratchFolder folder;
  write_truth(folder.path(), hill_flight(folder.path()));
  const auto cameras = words_of(folder / "colmap/cameras.txt", ' ');
  const auto images = words_of(folder / "colmap/images.txt", ' ');
  const auto points = words_of(folder / "colmap/points3D.txt", ' ');
  ASSERT_EQ(cameras.at(0).at(1), "OPENCV");
  ASSERT_EQ(images.size(), 12U);
  ASSERT_GT(points.size(), 200U);
  std::vector<double> observations(6);
  for (const auto& point : points) {
    const Vec3 position(std::stod(point.at(1)), std::stod(point.at(2)), std::stod(point.at(3)));
    ASSERT_NEAR(position.z(), hill(position.x(), position.y()), 0.01);
    ASSERT_GE(point.size(), 12U);  // two elements of a track at least
    for (std::size_t i = 8; i < point.size(); i += 2) {
      const std::size_t image = 2 * (std::stoul(point[i]) - 1), index = 3 * std::stoul(point.at(i + 1));
      double q[4];
      for (std::size_t n = 0; n < 4; ++n) q[n] = std::stod(images[image].at(1 + n));
      const Vec3 t(std::stod(images[image].at(5)), std::stod(images[image].at(6)), std::stod(images[image].at(7)));
      const Vec2 expected = opencv_pixel(cameras[0], rotation_from_quaternion(q) * position + t);
      ASSERT_NEAR(std::stod(images[image + 1].at(index)), expected.x(), 1e-5);
      ASSERT_NEAR(std::stod(images[image + 1].at(index + 1)), expected.y(), 1e-5);
      ASSERT_EQ(images[image + 1].at(index + 2), point.at(0));
      ++observations[image / 2];
    }
  }
  for (const double count : observations) EXPECT_GT(count, 50);
}

TEST(WriteTruth, SameBytesForOneThreadAndForSeveral) {
  const test::ScratchFolder several, one;
  write_truth(several.path(), hill_flight(several.path()), 5);
  const std::filesystem::path alone = one.path() / "alone";
  const TruthSource source = hill_flight(alone);
  write_truth(alone, source, 1);
  for (const char* name : {"overlap.csv", "visible-before/0004.png", "height.pfm", "height.pgw", "height.tif",
                           "colmap/cameras.txt", "colmap/images.txt", "colmap/points3D.txt"}) {
    EXPECT_FALSE(test::text_of(alone / name).empty()) << name;
    EXPECT_EQ(test::text_of(alone / name), test::text_of(several / name)) << name;
  }
}

TEST(WriteTruth, BadInputIsNamed) {
  const test::ScratchFolder folder;
  TruthSource source = hill_flight(folder.path());
  host::write_pfm(folder / "depth/0003.pfm", host::Raster<float>(80, 60, 1).view());
  EXPECT_TRUE(test::says(test::error_of([&] { write_truth(folder.path(), source); }), "0003.pfm: 80 x 60 pixels"));
  source.names.pop_back();
  EXPECT_THROW(write_truth(folder.path(), source), std::invalid_argument);
  folder.write("height.pgw", "0.5\n0\n0\n-0.4\n0\n0\n");
  EXPECT_TRUE(test::says(test::error_of([&] { (void)read_height_grid(folder.path()); }), "height.pgw: expected six"));
}

}  // namespace
}  // namespace ilp::world
