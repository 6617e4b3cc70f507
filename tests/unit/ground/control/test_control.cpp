// Control points: triangulation, the similarity that most points agree on, and the file.
#include <gtest/gtest.h>
#include <ogr_spatialref.h>

#include <cmath>

#include "fsw/vision/geometry/camera.hpp"
#include "sim/ground/control/control_file.hpp"
#include "sim/ground/control/control_fit.hpp"
#include "sim/ground/control/control_system.hpp"
#include "sim/host/gdal_session.hpp"
#include "tests/unit/host/scratch_folder.hpp"

namespace ilp {
namespace {

using control::Sight;
using control::Surveyed;

CameraModel distorted_camera() {
  CameraModel camera{640, 480, 500, 500, 319.5, 239.5, -0.08};
  return camera;
}

Sight sight_of(const Vec3& centre, const Vec3& point) {
  Sight sight{.camera = distorted_camera(), .cam_from_world = Vec3(1, -1, -1).asDiagonal(), .centre = centre};
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

TEST(ControlFile, SpreadsheetsAreReadAsTheySaveIt) {
  const test::ScratchFolder folder;
  for (const char* text :
       {"\xEF\xBB\xBFname,x,y,height,sigma,role\na,1.5,2,3,0.1,control,1.png,5,6\n",
        "name;x;y;height;sigma;role\r\na;1,5;2;3;0,1;control;1.png;5;6\r\n",
        "name,x,y,height,sigma,role\na;1,5;2;3;0,1;control;1.png;5;6\n",
        "Name, X ,Y,Height,SIGMA,role\na,1.5,2,3,0.1,control,1.png,5,6\n",
        "name,x,y,height,sigma,role,,,,,,\na,1.5,2,3,0.1,control,1.png,5,6,,,\n",
        "\"name\",\"x\",\"y\",\"height\",\"sigma\",\"role\"\n\"a\",1.5,2,3,0.1,\"control\",\"1.png\",5,6\n"}) {
    const auto file = control::read_control_file(folder.write("points.csv", text));
    ASSERT_EQ(file.points.size(), 1U) << text;
    EXPECT_EQ(file.points[0].place, Vec3(1.5, 2, 3)) << text;
    EXPECT_EQ(file.points[0].sigma_m, 0.1) << text;
    ASSERT_EQ(file.points[0].marks.size(), 1U) << text;
    EXPECT_EQ(file.points[0].marks[0].pixel, Vec2(5, 6)) << text;
  }
}

TEST(ControlFile, TheListOfOdmIsRead) {
  const test::ScratchFolder folder;
  const auto file =
      control::read_control_file(folder.write("gcp_list.txt",
                                              "WGS84 UTM 33N\n500010.5 5200020.25 300 10.5 20 a.JPG rim\n"
                                              "500010.5 5200020.25 300 30 40 b.JPG rim\n600000 5200000 310 1 2 a.JPG\n"
                                              "600000 5200000 310 3 4 b.JPG\n"));
  EXPECT_EQ(file.system, "EPSG:32633");
  EXPECT_TRUE(file.original_pixels);
  ASSERT_EQ(file.points.size(), 2U);
  EXPECT_EQ(file.points[0].name, "rim");
  EXPECT_EQ(file.points[0].marks.size(), 2U);
  EXPECT_EQ(file.points[1].marks[1].pixel, Vec2(3, 4));
  EXPECT_FALSE(file.points[1].check);
  const auto refused = [&](const std::string& text) {
    return test::error_of([&] { (void)control::read_control_file(folder.write("gcp_list.txt", text)); });
  };
  EXPECT_TRUE(test::says(refused("EPSG:32633\n1 2 3 4 a.JPG\n"), "line 2: 5 values"));
  EXPECT_TRUE(test::says(refused("EPSG:32633\n1 2 3 4 5 a.JPG p\n1 2 4 4 5 b.JPG p\n"), "line 3: the point p has two"));
}

control::ControlFile point_at(double x, double y, double height) {
  control::ControlFile file;
  control::ControlPoint& point = file.points.emplace_back();
  point.name = "a";
  point.place = {x, y, height};
  point.marks.push_back({"1.png", {1001.5, 601.5}});
  return file;
}

TEST(ControlSystem, CoordinatesOfAStatedSystemBecomeDegrees) {
  // The central meridian of zone 33 at the equator: 15 degrees east, by definition.
  control::ControlFile file = point_at(500'000, 0, 300);
  const control::ControlSystem utm{"EPSG:4326", "EPSG:32633", ""};
  EXPECT_TRUE(control::is_on_earth(file, utm));
  control::resolve(utm, file);
  EXPECT_TRUE(file.geographic);
  EXPECT_NEAR(file.points[0].place.x(), 15, 1e-9);
  EXPECT_NEAR(file.points[0].place.y(), 0, 1e-9);
  EXPECT_EQ(file.points[0].place.z(), 300);
  control::ControlFile plain = point_at(1, 2, 3);
  control::resolve({}, plain);
  EXPECT_FALSE(plain.geographic || control::is_on_earth(plain, {}));
  EXPECT_EQ(plain.points[0].place, Vec3(1, 2, 3));
  EXPECT_TRUE(test::says(test::error_of([&] {
                           control::resolve({"EPSG:4326", "EPSG:nothing", ""}, plain);
                         }),
                         "\"EPSG:nothing\" is not known"));
  EXPECT_TRUE(test::says(test::error_of([&] {
                           control::resolve({"IAU_2015:49900", "EPSG:32633", ""}, plain);
                         }),
                         "to another body"));
}

TEST(ControlSystem, HeightsAboveTheGeoidBecomeHeightsAboveTheFigure) {
  control::ControlFile file = point_at(15, 0, 300);
  file.geographic = true;
  control::resolve({"EPSG:4326", "", "-12.5"}, file);
  EXPECT_EQ(file.points[0].place.z(), 287.5);
  const test::ScratchFolder folder;
  const std::string raster = (folder / "geoid.tif").string();
  {
    // Ten degrees a pixel around the body; heights rise by 1 m to the east and fall by 2 m to the south.
    const host::GdalSession gdal;
    const host::Dataset geoid(
        GetGDALDriverManager()->GetDriverByName("GTiff")->Create(raster.c_str(), 36, 18, 1, GDT_Float32, nullptr));
    double transform[6] = {-180, 10, 0, 90, 0, -10};
    geoid->SetGeoTransform(transform);
    std::vector<float> heights;
    for (int row = 0; row < 18; ++row) {
      for (int column = 0; column < 36; ++column) heights.push_back(static_cast<float>(column - 2 * row));
    }
    ASSERT_EQ(
        geoid->GetRasterBand(1)->RasterIO(GF_Write, 0, 0, 36, 18, heights.data(), 36, 18, GDT_Float32, 0, 0, nullptr),
        CE_None);
  }
  const auto height_at = [&](double longitude, double latitude) {
    control::ControlFile there = point_at(longitude, latitude, 0);
    there.geographic = true;
    control::resolve({"EPSG:4326", "", raster}, there);
    return there.points[0].place.z();
  };
  EXPECT_NEAR(height_at(-175, 85), 0, 1e-6);
  EXPECT_NEAR(height_at(7.5, 80), 18.25 - 1, 1e-6);
  EXPECT_NEAR(height_at(367.5, 80), 18.25 - 1, 1e-6);
  EXPECT_NEAR(height_at(180, 85), 17.5, 1e-6) << "between the last column and the first";
  EXPECT_TRUE(test::says(test::error_of([&] { (void)height_at(0, 89); }), "has no height at control point a"));
}

TEST(ControlSystem, AGeoidIsReadByTheRuleOfHeights) {
  const test::ScratchFolder folder;
  const std::string raster = (folder / "geoid.tif").string();
  const auto write = [&](const char* system) {
    const host::GdalSession gdal;
    const host::Dataset geoid(
        GetGDALDriverManager()->GetDriverByName("GTiff")->Create(raster.c_str(), 4, 4, 1, GDT_Int16, nullptr));
    double transform[6] = {10, 1, 0, 50, 0, -1};
    geoid->SetGeoTransform(transform);
    OGRSpatialReference stated;
    ASSERT_EQ(stated.SetFromUserInput(system), OGRERR_NONE);
    geoid->SetSpatialRef(&stated);
    GDALRasterBand& band = *geoid->GetRasterBand(1);
    band.SetScale(0.01);
    band.SetUnitType("cm");
    band.SetNoDataValue(-32768);
    std::vector<std::int16_t> numbers(16, 4500);
    numbers[15] = -32768;
    ASSERT_EQ(band.RasterIO(GF_Write, 0, 0, 4, 4, numbers.data(), 4, 4, GDT_Int16, 0, 0, nullptr), CE_None);
  };
  const auto height_at = [&](double longitude, double latitude) {
    control::ControlFile there = point_at(longitude, latitude, 300);
    there.geographic = true;
    control::resolve({"EPSG:4326", "", raster}, there);
    return there.points[0].place.z();
  };
  write("EPSG:4326");
  EXPECT_NEAR(height_at(11, 48), 300.45, 1e-6) << "4500 hundredths of a centimetre";
  EXPECT_TRUE(test::says(test::error_of([&] { (void)height_at(13.2, 47); }), "has no height at control point a"));
  write("EPSG:32633");
  EXPECT_TRUE(test::says(test::error_of([&] { (void)height_at(11, 48); }), "geoid heights in degrees"));
}

TEST(ControlSystem, MarksInLargerPhotographsBecomeThoseOfTheFlight) {
  const control::FlownImages images{1000, 750, 4, [](const std::string& image) { return image == "1.png"; }};
  control::ControlFile file = point_at(0, 0, 0);
  control::fit_marks(images, false, file);
  EXPECT_EQ(file.points[0].marks[0].pixel, Vec2(250, 150)) << "the mark lay outside, so all are original ones";
  control::fit_marks(images, false, file);
  EXPECT_EQ(file.points[0].marks[0].pixel, Vec2(250, 150)) << "of the flight";
  control::fit_marks(images, true, file);
  EXPECT_EQ(file.points[0].marks[0].pixel.x(), 250.5 / 4 - 0.5);
  file = point_at(0, 0, 0);
  EXPECT_TRUE(test::says(test::error_of([&] {
                           control::fit_marks({1000, 750, 1, images.is_of_flight}, false, file);
                         }),
                         "marked in 1.png at column 1001.5"));
  file.points[0].marks[0].image = "of another flight.png";
  control::fit_marks({1000, 750, 1, images.is_of_flight}, false, file);
}

}  // namespace
}  // namespace ilp
