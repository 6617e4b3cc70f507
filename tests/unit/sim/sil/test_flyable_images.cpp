#include <gtest/gtest.h>
#include <tiffio.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "cfg/limits.hpp"
#include "sim/host/gdal_session.hpp"
#include "sim/host/image_io.hpp"
#include "sim/sil/flyable_images.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp::sil {
namespace {

namespace fs = std::filesystem;
using host::StripFrame;

std::vector<StripFrame> strip_of(const std::vector<fs::path>& files) {
  std::vector<StripFrame> strip;
  for (const fs::path& file : files)
    strip.push_back({static_cast<std::int64_t>(strip.size()) * 2'000'000'000, file, {}, true});
  return strip;
}

/// Uncompressed, one band, written by libtiff.
void write_tiff(const fs::path& path, int width, int height, const std::vector<std::uint16_t>& values) {
  TIFF* const tiff = TIFFOpen(path.c_str(), "w");
  ASSERT_NE(tiff, nullptr);
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, width);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, height);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 16);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  for (int y = 0; y < height; ++y) {
    std::vector<std::uint16_t> row(values.begin() + y * width, values.begin() + (y + 1) * width);
    TIFFWriteScanline(tiff, row.data(), static_cast<std::uint32_t>(y), 0);
  }
  TIFFClose(tiff);
}

void put(std::string& text, std::uint32_t value, int octets) {
  for (int i = 0; i < octets; ++i) text += static_cast<char>(value >> (8 * i) & 255U);
}

/// An Exif segment (CIPA DC-008): time of exposure and focal length for 35 mm film.
std::string exif_segment(const std::string& time, std::uint16_t focal_mm) {
  std::string tiff("II*\0\x08\0\0\0", 8);
  put(tiff, 1, 2);  // one entry: where the Exif directory is
  put(tiff, 0x8769, 2), put(tiff, 4, 2), put(tiff, 1, 4), put(tiff, 26, 4);
  put(tiff, 0, 4);
  put(tiff, 2, 2);
  put(tiff, 0x9003, 2), put(tiff, 2, 2), put(tiff, 20, 4), put(tiff, 56, 4);
  put(tiff, 0xA405, 2), put(tiff, 3, 2), put(tiff, 1, 4), put(tiff, focal_mm, 4);
  put(tiff, 0, 4);
  tiff += time + std::string(1, '\0');
  const std::string content = std::string("Exif\0\0", 6) + tiff;
  const std::size_t size = content.size() + 2;
  return std::string("\xFF\xE1") + static_cast<char>(size >> 8U) + static_cast<char>(size & 255U) + content;
}

/// A JPEG of GDAL with the segment behind its first marker.
void write_jpeg(const fs::path& path, int width, int height, std::uint8_t grey, const std::string& segment) {
  const fs::path plain = path.string() + ".plain";
  {
    const host::GdalSession session;
    const host::Dataset memory(
        GetGDALDriverManager()->GetDriverByName("MEM")->Create("", width, height, 3, GDT_Byte, nullptr));
    for (int band = 1; band <= 3; ++band) memory->GetRasterBand(band)->Fill(grey);
    const host::Dataset written(GetGDALDriverManager()->GetDriverByName("JPEG")->CreateCopy(
        plain.c_str(), memory.get(), FALSE, nullptr, nullptr, nullptr));
    ASSERT_TRUE(written);
  }
  std::ifstream in(plain, std::ios::binary);
  std::string jpeg{std::istreambuf_iterator<char>(in), {}};
  jpeg.insert(2, segment);
  std::ofstream(path, std::ios::binary) << jpeg;
  fs::remove(plain);
}

class FlyableImagesTest : public testing::Test {
 protected:
  FlyableImages make(const std::vector<fs::path>& files) { return make_flyable(strip_of(files), made_, messages_); }

  test::TemporaryFolder folder_;
  fs::path made_ = folder_ / "made";
  std::ostringstream messages_;
};

TEST_F(FlyableImagesTest, ImagesThatFlyAsTheyAreStayWhereTheyAre) {
  const fs::path image = folder_ / "a.png";
  host::write_png(image, host::Raster<std::uint8_t>(80, 64, 90).view());
  const FlyableImages flyable = make({image, folder_ / "none.png"});
  EXPECT_EQ(flyable.frames[0].file, image);
  EXPECT_EQ(flyable.frames[1].file, folder_ / "none.png") << "the flight reports it";
  EXPECT_EQ(flyable.binning, 1);
  EXPECT_EQ(messages_.str(), "");
}

TEST_F(FlyableImagesTest, TheContentTellsTheFormatWhateverTheName) {
  const fs::path png = folder_ / "video-000012", pgm = folder_ / "b.jpg";
  host::write_png(png, host::Raster<std::uint8_t>(80, 64, 90).view());
  host::write_pgm(pgm, host::Raster<std::uint8_t>(80, 64, 90).view());
  const FlyableImages flyable = make({png, pgm});
  EXPECT_EQ(flyable.frames[0].file, png) << "a frame keeps the name that its camera gave it";
  EXPECT_EQ(flyable.frames[1].file, pgm);
  EXPECT_EQ(messages_.str(), "");
}

TEST_F(FlyableImagesTest, SixteenBitsAreScaledByTheRangeOfTheStripAndNotCut) {
  std::vector<std::uint16_t> dark(80 * 64, 1000), light(80 * 64, 3000);
  dark[5] = 65535;  // a hot pixel
  write_tiff(folder_ / "dark.tif", 80, 64, dark);
  write_tiff(folder_ / "light.tif", 80, 64, light);
  const FlyableImages flyable = make({folder_ / "dark.tif", folder_ / "light.tif"});
  EXPECT_EQ(host::read_gray(flyable.frames[0].file).at(0, 0), 0);
  EXPECT_EQ(host::read_gray(flyable.frames[1].file).at(0, 0), 255);
  EXPECT_EQ(flyable.frames[0].file.filename(), "dark.png") << "a reference knows it by this name";
  EXPECT_NE(messages_.str().find("16-bit values from 1000 to 3000"), std::string::npos) << messages_.str();
}

TEST_F(FlyableImagesTest, JpegFilesBringTheirTimesAndTheirFieldOfView) {
  write_jpeg(folder_ / "one.jpg", 96, 64, 120, exif_segment("2026:11:22 08:40:00", 18));
  write_jpeg(folder_ / "two.jpg", 96, 64, 120, exif_segment("2026:11:22 08:40:03", 18));
  const FlyableImages flyable = make({folder_ / "one.jpg", folder_ / "two.jpg"});
  EXPECT_NEAR(host::read_gray(flyable.frames[0].file).at(40, 30), 120, 1);
  EXPECT_EQ(flyable.frames[1].time_ns, 3'000'000'000);
  EXPECT_FALSE(flyable.frames[1].time_is_assumed);
  ASSERT_TRUE(flyable.field_of_view_rad);
  EXPECT_NEAR(*flyable.field_of_view_rad, std::acos(-1) / 2, 1e-12) << "18 mm, half of the film's 36 mm";
}

TEST_F(FlyableImagesTest, BlanksInAPathAreNoHindrance) {
  fs::create_directories(folder_ / "my images");
  for (const char* name : {"a b.png", "a_b.png"})
    host::write_png(fs::path(folder_ / "my images") / name, host::Raster<std::uint8_t>(80, 64, 90).view());
  const FlyableImages flyable =
      make({fs::path(folder_ / "my images") / "a b.png", fs::path(folder_ / "my images") / "a_b.png"});
  EXPECT_EQ(flyable.frames[0].file, made_ / "a_b.png");
  EXPECT_EQ(flyable.frames[1].file, made_ / "a_b-2.png") << "no image takes the place of another";
  host::write_strip_index(folder_ / "frames.txt", flyable.frames);
  std::ifstream index(folder_ / "frames.txt");
  const std::string text{std::istreambuf_iterator<char>(index), {}};
  EXPECT_NE(text.find("\n0 made/a_b.png\n"), std::string::npos) << text;
}

TEST_F(FlyableImagesTest, LargeImagesAreBinnedAndTheirCameraWithThem) {
  const int width = 2 * limits::max_image_width + 2, height = 90;
  host::Raster<std::uint8_t> image(width, height, 0);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) image.at(x, y) = static_cast<std::uint8_t>(30 * (x % 3));
  }
  host::write_png(folder_ / "large.png", image.view());
  const FlyableImages flyable = make({folder_ / "large.png"});
  ASSERT_EQ(flyable.binning, 3);
  const host::Raster<std::uint8_t> small = host::read_gray(flyable.frames[0].file);
  EXPECT_EQ(small.width, width / 3);
  EXPECT_EQ(small.height, 30);
  EXPECT_EQ(small.at(10, 10), 30) << "the mean of 0, 30 and 60";
  CameraModel camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = 900;
  camera.cx = 4;  // the middle of the second block
  camera.cy = 1;
  const CameraModel binned = binned_camera(camera, 3);
  EXPECT_EQ(binned.width, small.width);
  EXPECT_DOUBLE_EQ(binned.fx, 300);
  EXPECT_DOUBLE_EQ(binned.cx, 1);
  EXPECT_DOUBLE_EQ(binned.cy, 0);
}

}  // namespace
}  // namespace ilp::sil
