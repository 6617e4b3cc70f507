// A rendered flight placed by control points of its world, whose places and marks are exact but for stated noise.
#include <gtest/gtest.h>
#include <ogr_spatialref.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "fsw/vision/geometry/camera.hpp"
#include "sim/host/gdal_session.hpp"
#include "sim/host/reference_cameras.hpp"
#include "tests/integration/flight_files.hpp"
#include "tests/support/page_text.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

constexpr double mark_noise_px = 0.3, survey_noise_m = 0.02, latitude_deg = -4.59;

struct Placed {
  std::string name;
  Vec3 place;
  std::string marks;
};

class ControlPoints : public ::testing::Test {
 protected:
  void SetUp() override {
    cameras_ = host::read_reference_cameras(truth_ / "poses.txt");
    for (std::size_t i = 0; i < cameras_.size(); i += 3) {
      const CameraModel& camera = cameras_[i].camera;
      add(i, 0.3 * camera.width, (i % 2 == 0 ? 0.25 : 0.7) * camera.height);
      add(i, 0.7 * camera.width, (i % 2 == 0 ? 0.75 : 0.35) * camera.height);
    }
    ASSERT_GE(points_.size(), 12U);
  }

  double noise(double sigma) { return sigma * normal_(random_); }

  static host::Raster<float> depth_of(const std::string& image) {
    return host::read_pfm(truth_ / "depth" / (fs::path(image).stem().string() + ".pfm"));
  }

  /// The ground at a pixel of an image, with its marks in all images that see it.
  void add(std::size_t image, double column, double row) {
    const host::ReferenceCamera& seen = cameras_[image];
    const auto x = static_cast<std::int32_t>(column), y = static_cast<std::int32_t>(row);
    const double depth = double{depth_of(seen.name).at(x, y)};
    ASSERT_GT(depth, 0);
    const Vec2 n = normalised_from_pixel(seen.camera, {double(x), double(y)});
    Placed point;
    point.name = "p" + std::to_string(points_.size());
    point.place = seen.centre + seen.cam_from_world.transpose() * Vec3(depth * n.x(), depth * n.y(), depth);
    for (const host::ReferenceCamera& camera : cameras_) {
      const Vec3 c = camera.cam_from_world * (point.place - camera.centre);
      const Vec2 at = pixel_from_normalised(camera.camera, {c.x() / c.z(), c.y() / c.z()});
      if (!(at.x() > 5 && at.y() > 5 && at.x() < camera.camera.width - 6 && at.y() < camera.camera.height - 6))
        continue;
      const float there =
          depth_of(camera.name).at(static_cast<std::int32_t>(at.x() + 0.5), static_cast<std::int32_t>(at.y() + 0.5));
      if (std::fabs(double{there} - c.z()) > 0.01 * c.z()) continue;
      point.marks += "," + camera.name + "," + std::to_string(at.x() + noise(mark_noise_px)) + "," +
                     std::to_string(at.y() + noise(mark_noise_px));
    }
    for (int axis = 0; axis < 3; ++axis) point.place[axis] += noise(survey_noise_m);
    points_.push_back(point);
  }

  /// Every third point is a check point. `p3` is surveyed 15 m too far east.
  fs::path file_of(bool geographic) {
    std::ofstream file(scratch_ / "control.csv");
    file.precision(15);
    file << (geographic ? "name,longitude,latitude,height,sigma,role\n" : "name,x,y,height,sigma,role\n");
    for (std::size_t i = 0; i < points_.size(); ++i) {
      Vec3 place = points_[i].place;
      if (i == 3) place.x() += 15;
      if (geographic) degrees_of(place);
      file << points_[i].name << "," << place.x() << "," << place.y() << "," << place.z() << "," << survey_noise_m
           << "," << (i % 3 == 2 ? "check" : "control") << points_[i].marks << "\n";
    }
    return scratch_ / "control.csv";
  }

  [[nodiscard]] OGRSpatialReference mercator() const {
    OGRSpatialReference metres, degrees;
    degrees.SetFromUserInput("IAU_2015:49900");
    metres.SetProjCS("Axes of the world");
    metres.CopyGeogCSFrom(&degrees);
    metres.SetTM(latitude_deg, longitude_deg_, 1, 0, 0);
    metres.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    return metres;
  }

  void degrees_of(Vec3& place) const {
    const OGRSpatialReference metres = mercator();
    OGRSpatialReference degrees;
    degrees.SetFromUserInput("IAU_2015:49900");
    degrees.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    OGRCoordinateTransformation* const way = OGRCreateCoordinateTransformation(&metres, &degrees);
    ASSERT_TRUE(way != nullptr && way->Transform(1, &place.x(), &place.y()));
    OGRCoordinateTransformation::DestroyCT(way);
    if (from_0_to_360_ && place.x() < 0) place.x() += 360;
  }

  static test::ProgramResult ran(const std::vector<std::string>& command) { return test::run_program(command); }

  test::ProgramResult run_ground(const fs::path& control, const fs::path& out, std::vector<std::string> more = {}) {
    std::vector<std::string> command{ILP_GROUND, flight_ / "outbox", "--out", out, "--control-points", control};
    command.insert(command.end(), more.begin(), more.end());
    return ran(command);
  }

  /// Median and 95 % of the height errors of the map that the points have placed, without any alignment.
  std::pair<double, double> height_errors(const fs::path& map, const fs::path& truth,
                                          const std::vector<std::string>& more) {
    std::vector<std::string> command{ILP_GROUND, "compare", map,     truth,
                                     "--fit",    "none",    "--out", scratch_ / "compared"};
    command.insert(command.end(), more.begin(), more.end());
    const test::ProgramResult result = ran(command);
    EXPECT_EQ(result.exit_status, 0) << result.output;
    const auto reported = nlohmann::json::parse(std::ifstream(scratch_ / "compared/comparison.json"));
    return {reported["difference"]["median_m"], reported["difference"]["abs_95_m"]};
  }

  void expect_placed(const fs::path& out) {
    const auto report = nlohmann::json::parse(std::ifstream(out / "report.json"));
    ASSERT_EQ(report["control"].size(), 1U);
    const auto& strip = report["control"][0];
    EXPECT_TRUE(strip["placed"].get<bool>());
    EXPECT_GE(strip["used"].get<int>(), 6);
    EXPECT_GE(strip["checked"].get<int>(), 3);
    EXPECT_LT(strip["check_rmse_m"].get<double>(), 0.3);
    for (const auto& point : strip["points"]) {
      if (point["name"] != "p3") {
        EXPECT_TRUE(point["check"].get<bool>() || point["used"].get<bool>()) << point;
        // The estimated sigma is for marks of one pixel. The poses add up to 0.1 m.
        const double sigma = std::hypot(mark_noise_px * point["expected_m"].get<double>(), 0.1);
        for (const auto& residual : point["residual_m"])
          EXPECT_LT(std::fabs(residual.get<double>()), 3 * sigma) << point;
        continue;
      }
      EXPECT_FALSE(point["used"].get<bool>());
      EXPECT_NEAR(point["residual_m"][0].get<double>(), -15, 0.5);
    }
  }

  test::TemporaryFolder scratch_folder_;
  fs::path scratch_ = scratch_folder_.path();
  inline static const fs::path flight_ = test::prepared_flights() / "uninterrupted",
                               truth_ = test::prepared_flights() / "plain/truth";
  std::vector<host::ReferenceCamera> cameras_;
  std::vector<Placed> points_;
  double longitude_deg_ = 137.44;
  bool from_0_to_360_ = false;

 private:
  std::mt19937 random_{11};
  std::normal_distribution<double> normal_;
};

TEST_F(ControlPoints, PlaceScaleAndLevelAMapAndAWrongOneIsNamed) {
  const fs::path out = scratch_ / "ground";
  const test::ProgramResult result = run_ground(file_of(false), out);
  ASSERT_EQ(result.exit_status, 0) << result.output;
  EXPECT_NE(result.output.find("Control point p3 is not used: it lies 1"), std::string::npos) << result.output;
  expect_placed(out);
  const auto [median, p95] = height_errors(out, truth_ / "height.tif", {"--same-axes"});
  EXPECT_LT(std::fabs(median), 0.25);  // three sigmas of nine such marks: 0.22 m
  EXPECT_LT(p95, 1);
  ILP_NEED_TOOL("node");
  const std::string page = test::page_text(out / "report.html");
  EXPECT_NE(page.find("<h2>Control points</h2>"), std::string::npos);
  EXPECT_NE(page.find("Control point p3 is not used: it lies 1"), std::string::npos);
}

TEST_F(ControlPoints, InLongitudeAndLatitudeTheMapLiesOnTheBody) {
  const fs::path out = scratch_ / "ground", control = file_of(true);
  EXPECT_NE(run_ground(control, out).output.find("need a body: name it with --control-body"), std::string::npos);
  const test::ProgramResult result = run_ground(control, out, {"--control-body", "mars"});
  ASSERT_EQ(result.exit_status, 0) << result.output;
  expect_placed(out);
  const fs::path truth = scratch_ / "truth.tif";
  fs::copy_file(truth_ / "height.tif", truth);
  {
    const host::GdalSession gdal;
    const host::Dataset file(GDALDataset::Open(truth.c_str(), GDAL_OF_RASTER | GDAL_OF_UPDATE));
    const OGRSpatialReference system = mercator();
    ASSERT_TRUE(file && file->SetSpatialRef(&system) == CE_None);
  }
  const auto [median, p95] = height_errors(out, truth, {});
  EXPECT_LT(std::fabs(median), 0.25);  // three sigmas of nine such marks: 0.22 m
  EXPECT_LT(p95, 1);
}

TEST_F(ControlPoints, AcrossTheDateLineTheResidualsAreTheSame) {
  const auto residuals = [&](double longitude_deg, bool from_0_to_360, const std::string& name) {
    longitude_deg_ = longitude_deg;
    from_0_to_360_ = from_0_to_360;
    const fs::path out = scratch_ / name;
    const test::ProgramResult result = run_ground(file_of(true), out, {"--control-body", "mars"});
    EXPECT_EQ(result.exit_status, 0) << result.output;
    const auto report = nlohmann::json::parse(std::ifstream(out / "report.json"));
    std::vector<double> all;
    for (const auto& point : report["control"][0]["points"]) {
      for (const auto& residual : point["residual_m"]) all.push_back(residual.get<double>());
    }
    return all;
  };
  const std::vector<double> inland = residuals(137.44, false, "inland");
  ASSERT_GT(inland.size(), 30U);
  for (const auto& [longitude_deg, from_0_to_360, name] :
       {std::tuple{180.0, false, "date-line"}, {0.0, true, "meridian"}}) {
    const std::vector<double> there = residuals(longitude_deg, from_0_to_360, name);
    ASSERT_EQ(there.size(), inland.size()) << name;
    for (std::size_t i = 0; i < inland.size(); ++i) EXPECT_NEAR(there[i], inland[i], 1e-3) << name;
  }
}

TEST_F(ControlPoints, InAStatedSystemTheMapLiesOnTheEarth) {
  // The axes of the world are those of UTM zone 33 about a point of its central meridian.
  const Vec3 origin(500'000, 5'200'000, 400);
  for (Placed& point : points_) point.place += origin;
  const fs::path out = scratch_ / "ground";
  const test::ProgramResult result = run_ground(file_of(false), out, {"--control-crs", "EPSG:32633"});
  ASSERT_EQ(result.exit_status, 0) << result.output;
  const auto report = nlohmann::json::parse(std::ifstream(out / "report.json"));
  ASSERT_TRUE(report["control"][0]["placed"].get<bool>());
  // The scale of UTM on its meridian is 0.9996, which 97 m of height see as 4 cm.
  EXPECT_LT(report["control"][0]["check_rmse_m"].get<double>(), 0.3);
  const host::GdalSession gdal;
  const host::Dataset map(GDALDataset::Open((out / "height.tif").c_str(), GDAL_OF_RASTER));
  ASSERT_TRUE(map && map->GetSpatialRef());
  EXPECT_NEAR(map->GetSpatialRef()->GetSemiMajor(), 6378137, 1e-6);
  double transform[6];
  ASSERT_EQ(map->GetGeoTransform(transform), CE_None);
  double x = transform[0], y = transform[3];
  OGRSpatialReference utm, own = *map->GetSpatialRef();
  utm.importFromEPSG(32633);
  for (OGRSpatialReference* system : {&utm, &own}) system->SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  OGRCoordinateTransformation* const way = OGRCreateCoordinateTransformation(&own, &utm);
  ASSERT_TRUE(way != nullptr && way->Transform(1, &x, &y));
  OGRCoordinateTransformation::DestroyCT(way);
  const Vec3 first = cameras_.front().centre + origin;
  EXPECT_LT(std::hypot(x - first.x(), y - first.y()), 1000) << "the map lies where its numbers are";
}

}  // namespace
}  // namespace ilp
