// Colours of photographs over ground whose place is known.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "sim/ground/export/colour_ortho.hpp"
#include "sim/host/gdal_session.hpp"
#include "tests/support/exif_file.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp::exports {
namespace {

namespace fs = std::filesystem;
using host::Rgb;

constexpr int width = 80, height = 64;
constexpr double focal = 80, altitude = 40;  // a pixel is half a unit on the ground

/// One camera at (3, -2, 40) that looks straight down on level ground: x of the image to +x, y to -y.
class ColourOrtho : public testing::Test {
 protected:
  ColourOrtho() {
    intake::Keyframe& keyframe = flight_.keyframes[7];
    keyframe.id = 7;
    keyframe.strip_id = 1;
    keyframe.name = "my_shot.png";
    keyframe.camera = {.width = width, .height = height, .fx = focal, .fy = focal, .cx = 39.5, .cy = 31.5};
    PoseRecord pose;
    pose.q_cam_from_world[0] = 0;
    pose.q_cam_from_world[1] = 1;
    pose.centre[0] = 3;
    pose.centre[1] = -2;
    pose.centre[2] = altitude;
    keyframe.pose = pose;
    strip_.strip.id = 1;
    strip_.strip.keyframes = {7};
    map::GroundGrid grid(-10, 8, 0.5, 50, 40);
    for (std::size_t i = 0; i < grid.height.samples.size(); ++i) {
      if (i % 50 == 0) continue;  // nothing was seen in the first column
      grid.height.samples[i] = 0;
      grid.ortho.samples[i] = 100;
      grid.source.samples[i] = 1;
    }
    strip_.grid = grid;
    fs::create_directories(photographs_);
  }
  /// Red where the ground has x < 3 and green elsewhere; blue below y = -2 in both.
  void write_photograph(const std::string& name, int binning) const {
    host::Raster<Rgb> picture(width * binning, height * binning);
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x) {
        const double column = (x + 0.5) / binning - 0.5, row = (y + 0.5) / binning - 0.5;
        const std::uint8_t blue = row > 31.5 ? 200 : 20;
        picture.at(x, y) = column < 39.5 ? Rgb{200, 20, blue} : Rgb{20, 200, blue};
      }
    }
    test::write_photograph(photographs_ / name, picture, {});
  }
  void paint() { write_colour_ortho(flight_, {}, photographs_, folder_ / "", strip_, messages_); }
  void expect_colours() {
    const host::GdalSession session;
    const host::Dataset written(GDALDataset::Open((folder_ / "colour.tif").c_str(), GDAL_OF_RASTER));
    ASSERT_TRUE(written);
    ASSERT_EQ(written->GetRasterCount(), 3);
    std::uint8_t bands[3][50 * 40];
    for (int band = 0; band < 3; ++band) {
      ASSERT_EQ(written->GetRasterBand(band + 1)->RasterIO(GF_Read, 0, 0, 50, 40, bands[band], 50, 40, GDT_Byte, 0, 0,
                                                           nullptr),
                CE_None);
    }
    for (int i = 0; i < 50 * 40; ++i) {
      const double x = -10 + 0.5 * (i % 50), y = 8 - 0.5 * (i / 50);
      const int red = bands[0][i], green = bands[1][i], blue = bands[2][i];
      if (i % 50 == 0) {
        EXPECT_EQ(red + green + blue, 0) << "nothing was seen";
        continue;
      }
      // JPEG keeps colours to some pixels.
      if (std::fabs(x - 3) < 3 || std::fabs(y + 2) < 3) continue;
      EXPECT_EQ(red > green, x < 3) << x << " " << y;
      EXPECT_EQ(blue > std::min(red, green) + 60, y < -2) << x << " " << y;
      // The brightness of the orthoimage, where no colour is beyond white.
      if (std::max({red, green, blue}) == 255) continue;
      EXPECT_NEAR(0.299 * red + 0.587 * green + 0.114 * blue, 100, 2);
    }
  }

  test::TemporaryFolder folder_;
  fs::path photographs_ = folder_ / "photographs";
  intake::Flight flight_;
  ExportedStrip strip_;
  std::ostringstream messages_;
};

TEST_F(ColourOrtho, EachCellHasTheColourOfItsPlaceAndTheBrightnessOfTheMap) {
  write_photograph("my shot.jpg", 1);
  paint();
  expect_colours();
  EXPECT_EQ(strip_.files, std::vector<std::string>{"colour.tif"});
  EXPECT_NE(messages_.str().find("colours of 1 of 1 keyframes"), std::string::npos) << messages_.str();
}

TEST_F(ColourOrtho, PhotographsMayBeLargerByAWholeFactor) {
  write_photograph("my_shot.jpg", 3);
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
