#include <gtest/gtest.h>

#include <memory>

#include "hal/camera/directory/directory_camera.hpp"
#include "sim/host/image_io.hpp"
#include "sim/host/strip.hpp"
#include "tests/unit/host/scratch_folder.hpp"

namespace ilp::host {
namespace {

namespace fs = std::filesystem;
using test::error_of;
using test::says;
using test::ScratchFolder;

void put_image(const fs::path& path, int width, std::uint8_t grey) {
  const Raster<std::uint8_t> image(width, 64, grey);
  if (path.extension() == ".pgm") {
    write_pgm(path, image.view());
  } else {
    write_png(path, image.view());
  }
}

TEST(Strip, ImagesComeInOrderOfTheirNamesTwoSecondsApart) {
  const ScratchFolder folder;
  put_image(folder / "b.png", 80, 20);
  put_image(folder / "a.pgm", 80, 10);
  put_image(folder / "c.PNG", 80, 30);
  folder.write("readme.md", "no image");
  const std::vector<StripFrame> frames = list_strip(folder.path());
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[0].file.filename(), "a.pgm");
  EXPECT_EQ(frames[1].file.filename(), "b.png");
  EXPECT_EQ(frames[2].file.filename(), "c.PNG");
  EXPECT_EQ(frames[0].time_ns, 0);
  EXPECT_EQ(frames[2].time_ns, 4'000'000'000);
  const std::vector<std::string> warnings = strip_warnings(frames);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(says(warnings[0], "has no times.txt: the images are taken as two seconds apart"));
}

TEST(Strip, NumbersInNamesCountByTheirValue) {
  const ScratchFolder folder;
  for (const char* name :
       {"img_121.png", "img_25.png", "img_1.png", "img_0030.png", "img_25b.png", "A 2.png", "A 10.png"})
    put_image(folder / name, 80, 20);
  std::string order;
  for (const StripFrame& frame : list_strip(folder.path())) order += frame.file.stem().string() + " ";
  EXPECT_EQ(order, "A 2 A 10 img_1 img_25 img_25b img_0030 img_121 ");
}

TEST(Strip, ListInTheFolderGivesOrderTimesAndAltitudes) {
  const ScratchFolder folder;
  for (const char* list : {"times.txt", "frames.txt", "index.txt"}) {
    fs::create_directories(folder / "images");
    folder.write(list, "# comment\n\n100 images/z.png 12.5\r\n250 images/a.png\n");
    const std::vector<StripFrame> frames = list_strip(folder.path());
    ASSERT_EQ(frames.size(), 2U) << list;
    EXPECT_EQ(frames[0].time_ns, 100);
    EXPECT_EQ(frames[0].file, folder / "images/z.png");
    EXPECT_EQ(frames[0].altitude, "12.5");
    EXPECT_EQ(frames[1].time_ns, 250);
    EXPECT_EQ(frames[1].altitude, "");
    fs::remove(folder / list);
  }
}

TEST(Strip, ImagesFolderInsideIsFound) {
  const ScratchFolder folder;
  fs::create_directories(folder / "images");
  put_image(folder / "images/a.png", 80, 10);
  ASSERT_EQ(list_strip(folder.path()).size(), 1U);
}

TEST(Strip, AStrayPictureBesideTheFolderOfImagesIsNoStrip) {
  const ScratchFolder folder;
  fs::create_directories(folder / "images");
  for (const char* name : {"a.png", "b.png", "c.png"}) put_image(folder / "images" / name, 80, 10);
  put_image(folder / "overview.png", 96, 10);
  ASSERT_EQ(list_strip(folder.path()).size(), 3U);
  EXPECT_EQ(list_strip(folder.path())[0].file, folder / "images/a.png");
  for (const char* name : {"1.png", "2.png", "3.png"}) put_image(folder / name, 96, 10);
  EXPECT_EQ(list_strip(folder.path()).size(), 4U) << "there are more images beside it than in it";
}

TEST(Strip, FilesThatBeginWithADotAreNoImages) {
  const ScratchFolder folder;
  put_image(folder / "a.png", 80, 10);
  folder.write("._a.png", "AppleDouble");
  folder.write(".b.png", "");
  ASSERT_EQ(list_strip(folder.path()).size(), 1U);
  EXPECT_EQ(list_strip(folder.path())[0].file, folder / "a.png");
}

TEST(Strip, NothingToFlyOrAMalformedListIsAnErrorThatSaysSo) {
  const ScratchFolder folder;
  EXPECT_TRUE(says(error_of([&] { (void)list_strip(folder.path()); }), "holds no image: name a folder"));
  EXPECT_TRUE(says(error_of([&] { (void)list_strip(folder / "none"); }), "is not a folder of images"));
  for (const char* line : {"1.5 a.png", "a.png", "12", "0x10 a.png", "1 a.png high", "1 a.png nan", "1 a.png 1e3",
                           "1 a.png 5 extra", "99999999999999999999 a.png"}) {
    folder.write("times.txt", std::string("0 first.png\n") + line + "\n");
    EXPECT_TRUE(says(error_of([&] { (void)list_strip(folder.path()); }), "line 2: expected time_ns name")) << line;
  }
}

TEST(Strip, WarningsNameEveryFrameThatWillNotFly) {
  const ScratchFolder folder;
  put_image(folder / "a.png", 80, 10);
  put_image(folder / "b.png", 96, 10);
  folder.write("c.png", "GIF89a");
  folder.write("times.txt", "0 a.png\n10 b.png\n20 c.png\n30 d.png\n30 a.png\n");
  const std::vector<std::string> warnings = strip_warnings(list_strip(folder.path()));
  ASSERT_EQ(warnings.size(), 4U);
  EXPECT_TRUE(says(warnings[0], "b.png has 96x64 pixels"));
  EXPECT_TRUE(says(warnings[1], "c.png: neither PNG nor binary PGM"));
  EXPECT_TRUE(says(warnings[2], "d.png: cannot be read"));
  EXPECT_TRUE(says(warnings[3], "not later"));
}

TEST(Strip, FlightCameraReadsTheIndexThatWasWritten) {
  const ScratchFolder folder;
  put_image(folder / "a.png", 80, 10);
  put_image(folder / "b.pgm", 80, 20);
  folder.write("times.txt", "5 a.png 101.25\n9 b.pgm\n");
  write_strip_index(folder / "index-out.txt", list_strip(folder.path()));
  DirectoryCamera camera;
  ASSERT_TRUE(camera.open((folder / "index-out.txt").c_str(), 80, 64, decode_image).ok());
  const auto image = std::make_unique<FrameImage>();
  CameraFrame frame;
  ASSERT_TRUE(camera.capture(100, *image, frame).ok());
  EXPECT_EQ(frame.time_ns, 5);
  EXPECT_EQ(frame.altitude, 101.25);
  EXPECT_STREQ(frame.name, "a.png");
  EXPECT_EQ(image->view().at(40, 30), 10);
  ASSERT_TRUE(camera.capture(100, *image, frame).ok());
  EXPECT_EQ(frame.time_ns, 9);
  EXPECT_NE(frame.altitude, frame.altitude);
  EXPECT_EQ(image->view().at(40, 30), 20);
  EXPECT_EQ(camera.capture(100, *image, frame).code, StatusCode::end_of_stream);
}

TEST(Strip, PathsThatTheIndexCannotHoldAreRefused) {
  const ScratchFolder folder;
  const StripFrame blank{0, folder / "a b.png", {}};
  const StripFrame endless{0, folder / (std::string(600, 'x') + ".png"), {}};
  EXPECT_TRUE(says(error_of([&] { write_strip_index(folder / "i", {blank}); }), "blanks in the path"));
  EXPECT_TRUE(says(error_of([&] { write_strip_index(folder / "i", {endless}); }), "too long"));
  EXPECT_TRUE(says(error_of([&] { write_strip_index(folder / "none/i", {}); }), "cannot be written"));
}

}  // namespace
}  // namespace ilp::host
