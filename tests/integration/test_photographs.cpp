// Photographs with positions and colours: the map lies where the photographs say, and has their colours.
#include <gtest/gtest.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>

#include "fsw/vision/geometry/camera.hpp"
#include "sim/host/colmap.hpp"
#include "sim/host/gdal_session.hpp"
#include "sim/host/reference_cameras.hpp"
#include "tests/integration/flight_files.hpp"
#include "tests/support/exif_file.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;
using host::Rgb;

constexpr double longitude_deg = 4.4, latitude_deg = 51.25, base_m = 100;

/// Metres east and north of a point of Belgium, and degrees.
class Axes {
 public:
  Axes() {
    degrees_.SetFromUserInput("EPSG:4326");
    metres_.SetProjCS("Axes of the world");
    metres_.CopyGeogCSFrom(&degrees_);
    metres_.SetTM(latitude_deg, longitude_deg, 1, 0, 0);
    degrees_.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    metres_.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  }
  void to_degrees(double& x, double& y) const { convert(metres_, degrees_, x, y); }
  [[nodiscard]] const OGRSpatialReference& metres() const { return metres_; }

 private:
  static void convert(const OGRSpatialReference& from, const OGRSpatialReference& to, double& x, double& y) {
    OGRCoordinateTransformation* const way = OGRCreateCoordinateTransformation(&from, &to);
    ASSERT_TRUE(way != nullptr && way->Transform(1, &x, &y));
    OGRCoordinateTransformation::DestroyCT(way);
  }
  OGRSpatialReference degrees_, metres_;
};

/// One raster of the ground segment with the way from its cells to metres of the axes.
struct Map {
  host::Dataset dataset;
  double transform[6] = {};
  OGRCoordinateTransformation* way = nullptr;

  Map(const fs::path& file, const Axes& axes) : dataset(GDALDataset::Open(file.c_str(), GDAL_OF_RASTER)) {
    if (!dataset) throw host::gdal_error(file.string());
    dataset->GetGeoTransform(transform);
    OGRSpatialReference own = *dataset->GetSpatialRef();
    own.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    way = OGRCreateCoordinateTransformation(&own, &axes.metres());
  }
  ~Map() { OGRCoordinateTransformation::DestroyCT(way); }
  Map(const Map&) = delete;
  Map& operator=(const Map&) = delete;

  [[nodiscard]] std::pair<double, double> place(int column, int row) const {
    double x = transform[0] + (column + 0.5) * transform[1], y = transform[3] + (row + 0.5) * transform[5];
    EXPECT_TRUE(way->Transform(1, &x, &y));
    return {x, y};
  }
  template <typename T>
  [[nodiscard]] std::vector<T> band(int number, GDALDataType type) const {
    const int width = dataset->GetRasterXSize(), height = dataset->GetRasterYSize();
    std::vector<T> samples(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    EXPECT_EQ(dataset->GetRasterBand(number)->RasterIO(GF_Read, 0, 0, width, height, samples.data(), width, height,
                                                       type, 0, 0, nullptr),
              CE_None);
    return samples;
  }
};

class Photographs : public ::testing::Test {
 protected:
  void SetUp() override {
    cameras_ = host::read_reference_cameras(truth_ / "poses.txt");
    ASSERT_GT(cameras_.size(), 10U);
    border_m_ = 0.5 * (cameras_.front().centre.x() + cameras_.back().centre.x());
    fs::create_directories(folder_ / "photographs");
    for (std::size_t i = 0; i < cameras_.size(); ++i) write(i);
  }

  /// Each pixel becomes a block of them.
  static host::Raster<Rgb> enlarge(const host::Raster<Rgb>& picture, int times) {
    host::Raster<Rgb> large(picture.width * times, picture.height * times);
    for (std::int32_t y = 0; y < large.height; ++y) {
      for (std::int32_t x = 0; x < large.width; ++x) large.at(x, y) = picture.at(x / times, y / times);
    }
    return large;
  }

  /// Ground west of the border is red, ground east of it blue: by the true depth of each pixel.
  void write(std::size_t index, int enlarged = 1) {
    const host::ReferenceCamera& camera = cameras_[index];
    const std::string stem = fs::path(camera.name).stem().string();
    const host::Raster<std::uint8_t> grey = host::read_gray(flight_ / "images" / camera.name);
    const host::Raster<float> depth = host::read_pfm(truth_ / "depth" / (stem + ".pfm"));
    host::Raster<Rgb> picture(grey.width, grey.height);
    for (std::int32_t y = 0; y < grey.height; ++y) {
      for (std::int32_t x = 0; x < grey.width; ++x) {
        const Vec2 n = normalised_from_pixel(camera.camera, {double(x), double(y)});
        const double z = double{depth.at(x, y)};
        const Vec3 ground = camera.centre + camera.cam_from_world.transpose() * Vec3(z * n.x(), z * n.y(), z);
        const double value = grey.at(x, y);
        const auto strong = static_cast<std::uint8_t>(std::min(255.0, 1.2 * value));
        const auto weak = static_cast<std::uint8_t>(0.9 * value);
        picture.at(x, y) = ground.x() < border_m_ ? Rgb{strong, weak, weak} : Rgb{weak, weak, strong};
      }
    }
    double east = camera.centre.x(), north = camera.centre.y();
    axes_.to_degrees(east, north);
    test::ExifTags tags;
    tags.set_place(east, north, camera.centre.z() + base_m);
    tags.error_m = test::ExifRational{1, 10};
    const auto minutes = 40 + (100 + 2 * index) / 60;
    char time[32];
    std::snprintf(time, sizeof time, "2026:11:22 08:%02d:%02d", static_cast<int>(minutes),
                  static_cast<int>((100 + 2 * index) % 60));
    tags.time = time;
    if (enlarged > 1) picture = enlarge(picture, enlarged);
    test::write_photograph(fs::path(folder_ / "photographs") / (stem + ".jpg"), picture, tags);
  }

  /// Of the map against the ground of this world, which lies about z = 0; m.
  [[nodiscard]] double median_height_error(const fs::path& ground) const {
    const Map heights(ground / "height.tif", axes_);
    const int width = heights.dataset->GetRasterXSize(), height = heights.dataset->GetRasterYSize();
    const auto z = heights.band<float>(1, GDT_Float32);
    const Map truth(truth_ / "height.tif", axes_);
    const int true_width = truth.dataset->GetRasterXSize(), true_height = truth.dataset->GetRasterYSize();
    const auto true_z = truth.band<float>(1, GDT_Float32);
    const auto at = [](const std::vector<float>& values, int columns, int column, int row) {
      return double{
          values[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)]};
    };
    std::vector<double> errors;
    for (int row = 0; row < height; row += 3) {
      for (int column = 0; column < width; column += 3) {
        const double value = at(z, width, column, row);
        if (!std::isfinite(value)) continue;
        const auto [x, y] = heights.place(column, row);
        // The truth is in the axes of the world.
        const int u = static_cast<int>(std::floor((x - truth.transform[0]) / truth.transform[1]));
        const int v = static_cast<int>(std::floor((y - truth.transform[3]) / truth.transform[5]));
        if (u < 0 || v < 0 || u >= true_width || v >= true_height) continue;
        const double expected = at(true_z, true_width, u, v);
        if (std::isfinite(expected)) errors.push_back(std::fabs(value - base_m - expected));
      }
    }
    EXPECT_GT(errors.size(), 500U) << "the map does not lie over the ground that it shows";
    if (errors.empty()) return 1e9;
    std::sort(errors.begin(), errors.end());
    return errors[errors.size() / 2];
  }

  const host::GdalSession session_;
  const Axes axes_;
  const fs::path flight_ = test::prepared_flights() / "plain", truth_ = flight_ / "truth";
  test::TemporaryFolder folder_;
  std::vector<host::ReferenceCamera> cameras_;
  double border_m_ = 0;
};

TEST_F(Photographs, PutTheMapInItsPlaceAndGiveItsColours) {
  const fs::path out = folder_ / "out", ground = folder_ / "ground";
  const auto flown = test::run_program(
      {ILP_SIL, "--images", folder_ / "photographs", "--camera", flight_ / "cameras.txt", "--out", out});
  ASSERT_EQ(flown.exit_status, 0) << flown.output;
  EXPECT_NE(flown.output.find("the positions that EXIF states in " + std::to_string(cameras_.size())),
            std::string::npos)
      << flown.output;
  const auto merged =
      test::run_program({ILP_GROUND, out / "outbox", "--out", ground, "--colour", folder_ / "photographs"});
  ASSERT_EQ(merged.exit_status, 0) << merged.output;

  // The camera swings about straight down, which is what it was assumed to be.
  EXPECT_LT(median_height_error(ground), 1.0);

  const Map colours(ground / "colour.tif", axes_);
  ASSERT_EQ(colours.dataset->GetRasterCount(), 3);
  const auto red = colours.band<std::uint8_t>(1, GDT_Byte), green = colours.band<std::uint8_t>(2, GDT_Byte),
             blue = colours.band<std::uint8_t>(3, GDT_Byte);
  std::size_t right = 0, wrong = 0, grey = 0;
  const int columns = colours.dataset->GetRasterXSize();
  for (std::size_t i = 0; i < red.size(); ++i) {
    if (red[i] < 20 && blue[i] < 20) continue;
    const auto [x, y] = colours.place(static_cast<int>(i % static_cast<std::size_t>(columns)),
                                      static_cast<int>(i / static_cast<std::size_t>(columns)));
    if (std::fabs(x - border_m_) < 4) continue;
    if (std::abs(red[i] - blue[i]) < 4) {
      ++grey;
      continue;
    }
    ((red[i] > blue[i]) == (x < border_m_) ? right : wrong) += 1;
  }
  EXPECT_GT(right, 1000U);
  EXPECT_LT(wrong, right / 50);
  EXPECT_LT(grey, right / 20);

  // Without the option the same files have the same bytes, and there is no colour.
  const fs::path plain = folder_ / "plain";
  const auto again = test::run_program({ILP_GROUND, out / "outbox", "--out", plain});
  ASSERT_EQ(again.exit_status, 0) << again.output;
  EXPECT_FALSE(fs::exists(plain / "colour.tif"));
  for (const char* name : {"height.tif", "ortho.tif", "count.tif", "ortho.png", "model.ply"}) {
    EXPECT_EQ(test::read_file(plain / name), test::read_file(ground / name)) << name;
  }
}

TEST_F(Photographs, LargerThanTheFlightTakesAreBinnedWithTheirCameraAndLieWhereTheyShould) {
  const CameraModel own = host::read_colmap_camera(flight_ / "cameras.txt");
  const int enlarged = 1024 / own.width + 1;
  for (std::size_t i = 0; i < cameras_.size(); ++i) write(i, enlarged);
  const auto times = static_cast<double>(enlarged);
  // COLMAP's pixel centres are at halves.
  std::ofstream(folder_ / "large.txt") << "1 OPENCV " << own.width * enlarged << " " << own.height * enlarged << " "
                                       << own.fx * times << " " << own.fy * times << " " << (own.cx + 0.5) * times
                                       << " " << (own.cy + 0.5) * times << " " << own.k1 << " " << own.k2 << " "
                                       << own.p1 << " " << own.p2 << "\n";
  const fs::path out = folder_ / "out", ground = folder_ / "ground";
  const auto flown = test::run_program(
      {ILP_SIL, "--images", folder_ / "photographs", "--camera", folder_ / "large.txt", "--out", out});
  ASSERT_EQ(flown.exit_status, 0) << flown.output;
  EXPECT_NE(flown.output.find("the images are larger than the flight takes"), std::string::npos) << flown.output;
  const auto merged = test::run_program({ILP_GROUND, out / "outbox", "--out", ground});
  ASSERT_EQ(merged.exit_status, 0) << merged.output;
  EXPECT_LT(median_height_error(ground), 1.0);
}

TEST_F(Photographs, AFolderWithoutFittingPhotographsIsToldAndHarmsNothing) {
  const fs::path flown = test::prepared_flights() / "uninterrupted";
  fs::create_directories(folder_ / "others");
  fs::copy_file(fs::path(folder_ / "photographs") / "0001.jpg", fs::path(folder_ / "others") / "beach.jpg");
  const auto merged =
      test::run_program({ILP_GROUND, flown / "outbox", "--out", folder_ / "ground", "--colour", folder_ / "others"});
  EXPECT_EQ(merged.exit_status, 0) << merged.output;
  EXPECT_NE(merged.output.find("none of the photographs in"), std::string::npos) << merged.output;
  EXPECT_FALSE(fs::exists(fs::path(folder_ / "ground") / "colour.tif"));
  const auto missing =
      test::run_program({ILP_GROUND, flown / "outbox", "--out", folder_ / "ground2", "--colour", folder_ / "nowhere"});
  EXPECT_EQ(missing.exit_status, 1);
  EXPECT_NE(missing.output.find("no such folder"), std::string::npos) << missing.output;
}

}  // namespace
}  // namespace ilp
