#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "cfg/limits.hpp"
#include "sim/host/files.hpp"
#include "sim/host/gdal_session.hpp"
#include "sim/host/image_io.hpp"
#include "sim/sil/flyable_images.hpp"
#include "sim/sil/one_camera.hpp"
#include "tests/support/exif_file.hpp"
#include "tests/support/tiff_file.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp::sil {
namespace {

namespace fs = std::filesystem;
using host::StripFrame;
using test::write_tiff;

std::vector<StripFrame> strip_of(const std::vector<fs::path>& files) {
  std::vector<StripFrame> strip;
  for (const fs::path& file : files)
    strip.push_back({static_cast<std::int64_t>(strip.size()) * 2'000'000'000, file, {}, true});
  return strip;
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
  CameraModel camera{.width = width, .height = height, .fx = 900, .fy = 900};
  camera.cx = 4;  // the middle of the second block
  camera.cy = 1;
  const CameraModel binned = binned_camera(camera, 3);
  EXPECT_EQ(binned.width, small.width);
  EXPECT_DOUBLE_EQ(binned.fx, 300);
  EXPECT_DOUBLE_EQ(binned.cx, 1);
  EXPECT_DOUBLE_EQ(binned.cy, 0);
}

void cut(const fs::path& path, double share) {
  fs::resize_file(path, static_cast<std::uintmax_t>(share * static_cast<double>(fs::file_size(path))));
}

/// With a texture, so that its data are longer than its header.
void write_noisy_jpeg(const fs::path& path, int width, int height) {
  host::Raster<host::Rgb> picture(width, height);
  std::uint32_t state = 7;
  for (host::Rgb& pixel : picture.samples) {
    state = state * 1664525U + 1013904223U;
    const auto grey = static_cast<std::uint8_t>(state >> 24U);
    pixel = {grey, grey, grey};
  }
  test::write_photograph(path, picture, {});
}

TEST_F(FlyableImagesTest, DamagedPhotographsAreLeftOutByNameWhateverTheirFormat) {
  std::vector<fs::path> files;
  for (const char* name : {"a.jpg", "b.jpg", "c.jpg"}) {
    files.push_back(folder_ / name);
    write_noisy_jpeg(files.back(), 320, 240);
  }
  cut(files[1], 0.4);
  {
    // Zeros in the last part, as a card leaves them.
    const auto size = fs::file_size(files[2]);
    cut(files[2], 0.3);
    fs::resize_file(files[2], size);
  }
  const FlyableImages jpeg = make(files);
  ASSERT_EQ(jpeg.frames.size(), 1U) << messages_.str();
  for (const char* name : {"b.jpg: damaged image", "c.jpg: damaged image"})
    EXPECT_NE(messages_.str().find(name), std::string::npos) << messages_.str();

  std::vector<std::uint16_t> values(320 * 240);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<std::uint16_t>(i * 31);
  for (const char* name : {"d.tif", "e.tif"}) write_tiff(folder_ / name, 320, 240, values);
  cut(folder_ / "e.tif", 0.4);
  const FlyableImages tiff =
      make_flyable(strip_of({folder_ / "d.tif", folder_ / "e.tif"}), folder_ / "made2", messages_);
  EXPECT_EQ(tiff.frames.size(), 1U) << messages_.str();
  EXPECT_NE(messages_.str().find("left out: " + std::string(folder_ / "e.tif")), std::string::npos) << messages_.str();
}

TEST_F(FlyableImagesTest, AnImageThatIsFarTooLargeIsNamedAndTakesNoMemory) {
  write_noisy_jpeg(folder_ / "a.jpg", 320, 240);
  write_noisy_jpeg(folder_ / "b.jpg", 320, 240);
  std::ifstream in(folder_ / "b.jpg", std::ios::binary);
  std::string jpeg{std::istreambuf_iterator<char>(in), {}};
  const std::size_t frame = jpeg.find("\xFF\xC0");
  ASSERT_NE(frame, std::string::npos);
  // Height and width of the frame (ITU-T T.81, B.2.2): 30000 and 40000.
  jpeg.replace(frame + 5, 4, std::string("\x75\x30\x9C\x40", 4));
  std::ofstream(folder_ / "b.jpg", std::ios::binary) << jpeg;
  const FlyableImages made = make({folder_ / "a.jpg", folder_ / "b.jpg"});
  EXPECT_EQ(made.frames.size(), 1U);
  EXPECT_EQ(made.binning, 1) << "nor does it halve the rest";
  EXPECT_NE(messages_.str().find("b.jpg: 40000x30000 pixels are too many"), std::string::npos) << messages_.str();
}

TEST_F(FlyableImagesTest, AFolderOfThousandsWithAZoomIsJudgedInLinearTime) {
  std::vector<Photo> all(20'000);
  for (std::size_t i = 0; i < all.size(); ++i) {
    host::PhotographFacts facts{.width = 320, .height = 240, .camera = "camera " + std::to_string(i % 7000)};
    // Half of them with one focal length, the others with all others.
    facts.focal_mm = i % 2 == 0 ? 24 : 25 + 1e-3 * static_cast<double>(i);
    all[i].header = facts;
    if (i % 4 == 0) all[i].header->camera = "the usual one";
  }
  keep_one_camera(all, {}, messages_);
  ASSERT_EQ(all.size(), 5000U) << messages_.str();
  EXPECT_EQ(all.front().header->focal_mm, 24);
}

TEST_F(FlyableImagesTest, ColourTablesBecomeLumaAndFloatsAreNamed) {
  {
    const host::GdalSession session;
    GDALDriver* const driver = GetGDALDriverManager()->GetDriverByName("GTiff");
    const host::Dataset palette(driver->Create((folder_ / "p.tif").c_str(), 80, 64, 1, GDT_Byte, nullptr));
    GDALColorTable table;
    const GDALColorEntry red{200, 0, 0, 255}, grey{90, 90, 90, 255};
    table.SetColorEntry(0, &red);
    table.SetColorEntry(1, &grey);
    palette->GetRasterBand(1)->SetColorTable(&table);
    palette->GetRasterBand(1)->Fill(1);
    const host::Dataset thermal(driver->Create((folder_ / "f.tif").c_str(), 80, 64, 1, GDT_Float32, nullptr));
    thermal->GetRasterBand(1)->Fill(21.5);
  }
  const FlyableImages flyable = make({folder_ / "p.tif", folder_ / "f.tif"});
  ASSERT_EQ(flyable.frames.size(), 1U) << messages_.str();
  EXPECT_EQ(host::read_gray(flyable.frames[0].file).at(5, 5), 90);
  EXPECT_NE(messages_.str().find("f.tif: samples of the type Float32: convert it to 8 or 16 bits"), std::string::npos)
      << messages_.str();
}

TEST_F(FlyableImagesTest, OneSizeFliesAndTheOthersAreCounted) {
  std::vector<fs::path> files;
  const auto add = [&](const std::string& name, int width, int height) {
    files.push_back(folder_ / name);
    host::write_png(files.back(), host::Raster<std::uint8_t>(width, height, 90).view());
  };
  for (int i = 0; i < 3; ++i) {
    add("t" + std::to_string(i) + ".png", 160, 128);
    add("v" + std::to_string(i) + ".png", 320, 240);
  }
  EXPECT_EQ(make(files).source, (host::ImageSize{320, 240})) << "as many: the larger ones";
  EXPECT_NE(messages_.str().find("left out: 3 photographs of 6 with another size than the others, 320x240 pixels; the "
                                 "first is " +
                                 std::string(folder_ / "t0.png") + ", 160x128 pixels"),
            std::string::npos)
      << messages_.str();
  const auto chosen = [&](const host::ImageSize& of_camera) {
    return make_flyable(strip_of(files), made_, messages_, of_camera).source;
  };
  EXPECT_EQ(chosen({160, 128}), (host::ImageSize{160, 128}));
  EXPECT_EQ(chosen({640, 480}), (host::ImageSize{320, 240})) << "of the camera's shape";
  EXPECT_EQ(chosen({640, 512}), (host::ImageSize{160, 128}));
  for (int i = 3; i < 20; ++i) add("t" + std::to_string(i) + ".png", 160, 128);
  EXPECT_EQ(make(files).frames.size(), 20U);
}

TEST_F(FlyableImagesTest, TwoLargeOnesDoNotHalveTheRest) {
  std::vector<fs::path> files;
  for (int i = 0; i < 5; ++i) {
    files.push_back(folder_ / ("i" + std::to_string(i) + ".png"));
    const int side = i < 2 ? 2 * limits::max_image_width : 320;
    host::write_png(files.back(), host::Raster<std::uint8_t>(side, 240, 90).view());
  }
  const FlyableImages flyable = make(files);
  EXPECT_EQ(flyable.binning, 1);
  EXPECT_EQ(flyable.frames.size(), 3U);
}

TEST_F(FlyableImagesTest, OneSensorFlies) {
  std::vector<fs::path> files;
  for (int i = 0; i < 5; ++i) {
    test::ExifTags tags{.model = i == 1 ? "MAVIC2-T" : "MAVIC2-V"};
    if (i == 4) tags.model.clear();
    files.push_back(folder_ / ("s" + std::to_string(i) + ".jpg"));
    test::write_photograph(files.back(), host::Raster<host::Rgb>(96, 64, host::Rgb{9, 9, 9}), tags);
  }
  EXPECT_EQ(make(files).frames.size(), 4U);
  EXPECT_NE(messages_.str().find("another sensor than the others, MAVIC2-V; the first is " +
                                 std::string(folder_ / "s1.jpg") + ", MAVIC2-T"),
            std::string::npos)
      << messages_.str();
}

TEST_F(FlyableImagesTest, NamesOfAnyLengthAndLettersAreOneEverywhere) {
  const std::string tall(100, 'x');
  std::set<std::string> keys;
  for (const std::string& name :
       {std::string("M\xC3\xBCller.png"), std::string("M\xC3\xB6ller.png"), tall + "1.png", tall + "2.png"}) {
    const std::string key = host::image_key(name);
    EXPECT_TRUE(keys.insert(key).second) << name;
    EXPECT_LE(key.size(), host::longest_image_key);
    EXPECT_EQ(host::safe_name(key + ".png"), key + ".png");
    EXPECT_EQ(host::image_key(key + ".png"), key) << "a key is its own";
    EXPECT_EQ(host::image_key("/some/where/" + name), key);
    const fs::path file = folder_ / name;
    host::write_png(file, host::Raster<std::uint8_t>(80, 64, 90).view());
    const FlyableImages flyable = make({file});
    EXPECT_EQ(flyable.frames[0].file, made_ / (key + ".png")) << "the flight carries it in 63 octets";
    fs::remove(made_ / (key + ".png"));
  }
  EXPECT_EQ(host::image_key("IMG_0001.JPG"), "IMG_0001");
  EXPECT_EQ(host::image_key("a b.png"), "a_b");
}

}  // namespace
}  // namespace ilp::sil
