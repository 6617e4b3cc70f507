// Control points: triangulation, the similarity that most points agree on, and the file.
#include <gtest/gtest.h>

#include <cmath>

#include "fsw/vision/geometry/camera.hpp"
#include "sim/ground/control/control_file.hpp"
#include "sim/ground/control/control_fit.hpp"
#include "tests/unit/host/scratch_folder.hpp"

namespace ilp {
namespace {

using control::Sight;
using control::Surveyed;

CameraModel distorted_camera() {
  CameraModel camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 500;
  camera.cx = 319.5;
  camera.cy = 239.5;
  camera.k1 = -0.08;
  return camera;
}

Sight sight_of(const Vec3& centre, const Vec3& point) {
  Sight sight;
  sight.camera = distorted_camera();
  sight.cam_from_world = Vec3(1, -1, -1).asDiagonal();
  sight.centre = centre;
  const Vec3 c = sight.cam_from_world * (point - centre);
  sight.pixel = pixel_from_normalised(sight.camera, {c.x() / c.z(), c.y() / c.z()});
  return sight;
}

TEST(ControlFit, APointIsWhereItsLinesOfSightMeet) {
  const Vec3 point(12, -7, 3);
  std::vector<Sight> sights{sight_of({0, 0, 100}, point), sight_of({20, 1, 101}, point), sight_of({41, -2, 99}, point)};
  const auto exact = control::triangulate(sights);
  ASSERT_TRUE(exact);
  EXPECT_LT((exact->point - point).norm(), 1e-9);
  EXPECT_LT(exact->rms_px, 1e-9);
  // A mark that is a pixel off moves it by about the error that is stated.
  sights[1].pixel.x() += 1;
  const auto moved = control::triangulate(sights);
  ASSERT_TRUE(moved);
  const double sigma = std::sqrt(moved->covariance.trace());
  EXPECT_LT((moved->point - point).norm(), 2 * sigma);
  EXPECT_GT(sigma, 0.1);
  EXPECT_LT(sigma, 2);
  // A mark that belongs elsewhere shows in the pixels.
  sights[1].pixel.y() += 60;
  EXPECT_GT(control::triangulate(sights)->rms_px, 20);
}

TEST(ControlFit, LinesThatAreNearlyParallelGiveNoPoint) {
  const Vec3 point(12, -7, 3);
  EXPECT_FALSE(control::triangulate({sight_of({0, 0, 100}, point)}));
  EXPECT_FALSE(control::triangulate({sight_of({0, 0, 100}, point), sight_of({0.2, 0, 100}, point)}));
}

/// Of a world that is turned, has a unit of 3.5 m, and lies elsewhere.
std::vector<Surveyed> survey(const std::vector<Vec3>& worlds) {
  const Mat3 turn = Eigen::AngleAxisd(0.6, Vec3(0.3, -0.2, 0.9).normalized()).toRotationMatrix();
  std::vector<Surveyed> points;
  for (const Vec3& world : worlds) {
    points.push_back({world, 1e-6 * Mat3::Identity(), Vec3(3.5 * (turn * world) + Vec3(4000, -700, 250)), 0.05, true});
  }
  return points;
}

const std::vector<Vec3> spread = {{0, 0, 0}, {10, 1, 0.5}, {21, -3, 1}, {5, 12, -1}, {17, 9, 0.2}, {28, 6, 0}};

TEST(ControlFit, MostPointsDecideAndWrongOnesAreLeftOut) {
  std::vector<Surveyed> points = survey(spread);
  points[1].place.x() += 4;
  points[4].place.z() -= 2;
  const auto fit = control::fit_control(points);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->place_from_world.scale, 3.5, 1e-9);
  EXPECT_EQ(fit->used, (std::vector<bool>{true, false, true, true, false, true}));
  EXPECT_NEAR(fit->residual[1].x(), -4, 1e-6);
  EXPECT_NEAR(fit->residual[4].z(), 2, 1e-6);
}

TEST(ControlFit, CheckPointsAreMeasuredAndChangeNothing) {
  std::vector<Surveyed> points = survey(spread);
  points[2].usable = false;
  points[2].place += Vec3(0, 0.7, 0);
  const auto fit = control::fit_control(points);
  ASSERT_TRUE(fit);
  EXPECT_FALSE(fit->used[2]);
  EXPECT_NEAR(fit->residual[2].y(), -0.7, 1e-6);
  EXPECT_NEAR(fit->residual[0].norm(), 0, 1e-6);
}

TEST(ControlFit, PointsOnALineOrTwoPointsOrContradictionsPlaceNothing) {
  EXPECT_FALSE(control::fit_control(survey({{0, 0, 0}, {10, 0, 0}})));
  EXPECT_FALSE(control::fit_control(survey({{0, 0, 0}, {10, 0.1, 0}, {20, 0, 0}, {35, 0.1, 0}})));
  std::vector<Surveyed> points = survey({{0, 0, 0}, {10, 1, 0.5}, {5, 12, -1}});
  points[0].place.x() += 20;
  EXPECT_FALSE(control::fit_control(points));
}

TEST(ControlFile, IsReadWithItsMarksAndRoles) {
  const test::ScratchFolder folder;
  const auto file = control::read_control_file(
      folder.write("points.csv",
                   "# surveyed\nname,longitude,latitude,height,sigma,role\n"
                   "a,137.1,-4.5,-4400,0.05,control,1.png,100.5,20,2.png,90,21\nb,137.2,-4.6,-4399,1,check\n"));
  EXPECT_TRUE(file.geographic);
  ASSERT_EQ(file.points.size(), 2U);
  ASSERT_EQ(file.points[0].marks.size(), 2U);
  EXPECT_EQ(file.points[0].marks[1].image, "2.png");
  EXPECT_EQ(file.points[0].marks[0].pixel.x(), 100.5);
  EXPECT_TRUE(file.points[1].check);
}

TEST(ControlFile, MistakesAreNamedWithTheirLine) {
  const test::ScratchFolder folder;
  const std::string head = "name,x,y,height,sigma,role\n";
  const auto refused = [&](const std::string& text) {
    return test::error_of([&] { (void)control::read_control_file(folder.write("points.csv", text)); });
  };
  EXPECT_TRUE(test::says(refused("easting,northing\n"), "line 1: the first line must be name,x,y"));
  EXPECT_TRUE(test::says(refused(head + "a,1,2,3,0.1,control,1.png,5\n"), "line 2: 8 values"));
  EXPECT_TRUE(test::says(refused(head + "a,1,two,3,0.1,control\n"), "line 2: y is \"two\""));
  EXPECT_TRUE(test::says(refused(head + "a,1,2,3,0,control\n"), "sigma must be positive"));
  EXPECT_TRUE(test::says(refused(head + "a,1,2,3,1,use\n"), "control or check expected"));
  EXPECT_TRUE(test::says(refused(head + "a,1,2,3,1,check\na,1,2,3,1,check\n"), "line 3: the name a stands twice"));
  EXPECT_TRUE(test::says(refused(head), "no point in the file"));
  EXPECT_TRUE(
      test::says(refused("name,longitude,latitude,height,sigma,role\na,10,99,3,1,check\n"), "latitudes from -90"));
}

}  // namespace
}  // namespace ilp
