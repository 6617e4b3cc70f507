// Colours of photographs over ground whose place is known.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <sstream>

#include "sim/ground/export/colour_ortho.hpp"
#include "sim/host/gdal_session.hpp"
#include "sim/host/image_io.hpp"
#include "tests/support/exif_file.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp::exports {
namespace {

namespace fs = std::filesystem;
using host::Rgb;

constexpr int width = 80, height = 64;
constexpr double focal = 80, altitude = 40;  // a pixel is half a unit on the ground

constexpr int columns = 50, rows = 40;
constexpr double left = -10, top = 8, cell = 0.5;
constexpr double first_x = 3, second_x = 27, camera_y = -2;

/// Two cameras that look straight down: x of the image to +x, y to -y. The second one saw only a part of the cells that
/// are said to be from its image.
class ColourOrtho : public testing::Test {
 protected:
  ColourOrtho() {
    add_keyframe(7, "my_shot.png", first_x);
    add_keyframe(9, "other.png", second_x);
    strip_.strip.id = 1;
    map::GroundGrid grid(left, top, cell, columns, rows);
    for (int i = 0; i < columns * rows; ++i) {
      if (i % columns == 0) continue;  // nothing was seen in the first column
      const auto at = static_cast<std::size_t>(i);
      grid.height.samples[at] = static_cast<float>(height_of(i));
      grid.ortho.samples[at] = static_cast<std::uint8_t>(grey_of(i));
      grid.source.samples[at] = of_second(i) ? 2 : 1;
    }
    strip_.grid = grid;
    fs::create_directories(photographs_);
  }
  void add_keyframe(std::int64_t id, const std::string& name, double x) {
    intake::Keyframe& keyframe = flight_.keyframes[id];
    keyframe.id = id;
    keyframe.strip_id = 1;
    keyframe.name = name;
    keyframe.camera = {.width = width, .height = height, .fx = focal, .fy = focal, .cx = 39.5, .cy = 31.5};
    PoseRecord pose;
    pose.q_cam_from_world[0] = 0;
    pose.q_cam_from_world[1] = 1;
    pose.centre[0] = x;
    pose.centre[1] = camera_y;
    pose.centre[2] = altitude;
    keyframe.pose = pose;
    strip_.strip.keyframes.push_back(id);
  }
  static double x_of(int i) { return left + cell * (i % columns); }
  static double y_of(int i) { return top - cell * (i / columns); }
  static double height_of(int i) { return i / columns < 20 ? 0 : 10; }
  static int grey_of(int i) { return 60 + i / columns; }
  static bool of_second(int i) { return i % columns >= 30; }

  /// The first photograph: red left of its column 31 and green elsewhere; blue below row 41 in both. The second one:
  /// blue.
  void write_photographs(const std::string& first, int binning) const {
    host::Raster<Rgb> picture(width * binning, height * binning);
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x) {
        const std::uint8_t blue = y >= 41 * binning ? 200 : 20;
        picture.at(x, y) = x < 31 * binning ? Rgb{200, 20, blue} : Rgb{20, 200, blue};
      }
    }
    write(first, picture);
    write("other.png", host::Raster<Rgb>(width * binning, height * binning, Rgb{20, 120, 200}));
  }
  void write(const std::string& name, const host::Raster<Rgb>& picture) const {
    host::write_png(photographs_ / name,
                    ImageView<const Rgb>{picture.samples.data(), picture.width, picture.height, picture.width});
  }
  void paint() { write_colour_ortho(flight_, {}, photographs_, folder_ / "", strip_, messages_); }

  static void expect_first(int i, int red, int green, int blue) {
    const double column = 39.5 + focal * (x_of(i) - first_x) / (altitude - height_of(i));
    const double row = 31.5 - focal * (y_of(i) - camera_y) / (altitude - height_of(i));
    // Between two pixels both are right.
    if (std::fabs(column - 30.5) < 0.01 || std::fabs(row - 40.5) < 0.01) return;
    EXPECT_EQ(red > green, column < 30.5) << column << " " << row;
    EXPECT_EQ(blue > std::min(red, green) + 50, row > 40.5) << column << " " << row;
  }
  static void expect_second(int i, int red, int green, int blue) {
    const double column = 39.5 + focal * (x_of(i) - second_x) / (altitude - height_of(i));
    if (std::fabs(column + 1) < 0.01) return;
    if (column < -1) {
      EXPECT_TRUE(red == grey_of(i) && green == red && blue == red) << "the photograph does not show it";
    } else {
      EXPECT_GT(blue, green + 30) << column;
    }
  }
  void expect_colours() {
    const host::GdalSession session;
    const host::Dataset written(GDALDataset::Open((folder_ / "colour.tif").c_str(), GDAL_OF_RASTER));
    ASSERT_TRUE(written);
    ASSERT_EQ(written->GetRasterCount(), 3);
    std::array<double, 6> place{};
    ASSERT_EQ(written->GetGeoTransform(place.data()), CE_None);
    EXPECT_EQ(place, (std::array<double, 6>{left - cell / 2, cell, 0, top + cell / 2, 0, -cell}));
    std::uint8_t bands[3][columns * rows];
    for (int band = 0; band < 3; ++band) {
      int stated = 0;
      EXPECT_EQ(written->GetRasterBand(band + 1)->GetNoDataValue(&stated), 0);
      EXPECT_NE(stated, 0) << "a GIS would show the unseen cells black";
      ASSERT_EQ(written->GetRasterBand(band + 1)->RasterIO(GF_Read, 0, 0, columns, rows, bands[band], columns, rows,
                                                           GDT_Byte, 0, 0, nullptr),
                CE_None);
    }
    for (int i = 0; i < columns * rows; ++i) {
      const int red = bands[0][i], green = bands[1][i], blue = bands[2][i];
      if (i % columns == 0) {
        EXPECT_EQ(red + green + blue, 0) << "nothing was seen";
        continue;
      }
      of_second(i) ? expect_second(i, red, green, blue) : expect_first(i, red, green, blue);
      // The brightness of the orthoimage, by ITU-R BT.601, to the rounding of three colours.
      EXPECT_NEAR(0.299 * red + 0.587 * green + 0.114 * blue, grey_of(i), 0.5);
    }
  }

  test::TemporaryFolder folder_;
  fs::path photographs_ = folder_ / "photographs";
  intake::Flight flight_;
  ExportedStrip strip_;
  std::ostringstream messages_;
};

TEST_F(ColourOrtho, EachCellHasTheColourOfItsPlaceAndTheBrightnessOfTheMap) {
  write_photographs("my shot.png", 1);
  paint();
  expect_colours();
  EXPECT_EQ(strip_.files, std::vector<std::string>{"colour.tif"});
  EXPECT_NE(messages_.str().find("colours of 2 of 2 keyframes"), std::string::npos) << messages_.str();
}

TEST_F(ColourOrtho, PhotographsMayBeLargerByAWholeFactor) {
  write_photographs("my_shot.png", 3);
  paint();
  expect_colours();
}

TEST_F(ColourOrtho, PhotographsThatDoNotFitAreNamedAndNotUsed) {
  test::write_photograph(photographs_ / "my_shot.jpg", host::Raster<Rgb>(width + 30, height, Rgb{1, 2, 3}), {});
  paint();
  EXPECT_TRUE(strip_.files.empty());
  EXPECT_FALSE(fs::exists(folder_ / "colour.tif"));
  EXPECT_NE(messages_.str().find("110x64"), std::string::npos) << messages_.str();
  EXPECT_NE(messages_.str().find("none of the photographs"), std::string::npos) << messages_.str();
}

}  // namespace
}  // namespace ilp::exports
