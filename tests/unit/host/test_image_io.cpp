#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>

#include "fsw/base/crc.hpp"
#include "fsw/base/rng.hpp"
#include "sim/host/image_io.hpp"
#include "tests/unit/host/scratch_folder.hpp"

namespace ilp::host {
namespace {

using test::error_of;
using test::says;
using test::ScratchFolder;
using test::text_of;

Raster<std::uint8_t> random_image(int width, int height) {
  Raster<std::uint8_t> image(width, height);
  Rng rng(5);
  for (std::uint8_t& pixel : image.samples) pixel = static_cast<std::uint8_t>(rng.below(256));
  return image;
}

std::string big_endian(std::uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> static_cast<unsigned>(shift));
  return bytes;
}

/// As far as the length of the first block of pixel data, where the header counts as read.
std::string png_of_size(std::uint32_t width, std::uint32_t height) {
  std::string header = "IHDR" + big_endian(width) + big_endian(height);
  header += std::string("\x08\x00\x00\x00\x00", 5);
  const auto* data = reinterpret_cast<const std::uint8_t*>(header.data());
  return "\x89PNG\r\n\x1a\n" + big_endian(13) + header + big_endian(crc32({data, header.size()})) + big_endian(16) +
         "IDAT";
}

TEST(ImageIo, PngAndPgmGiveBackEveryPixelAlsoOfAnImageWithStride) {
  const ScratchFolder folder;
  const Raster<std::uint8_t> image = random_image(37, 21);
  const ImageView<const std::uint8_t> part = image.view().crop(3, 2, 30, 17);
  write_png(folder / "a.png", part);
  write_pgm(folder / "a.pgm", part);
  for (const char* name : {"a.png", "a.pgm"}) {
    const Raster<std::uint8_t> read = read_gray(folder / name);
    ASSERT_EQ(read.width, 30);
    ASSERT_EQ(read.height, 17);
    EXPECT_EQ(read_image_size(folder / name), (ImageSize{30, 17}));
    for (int y = 0; y < 17; ++y) {
      for (int x = 0; x < 30; ++x) ASSERT_EQ(read.at(x, y), image.at(x + 3, y + 2)) << name << " " << x << "," << y;
    }
  }
}

TEST(ImageIo, ColourPngHoldsItsColoursInOrder) {
  const ScratchFolder folder;
  Raster<Rgb> picture(3, 2);
  picture.at(1, 0) = {200, 100, 50};
  picture.at(2, 1) = {1, 2, 3};
  write_png(folder / "c.png", picture.view());
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_file(&png, (folder / "c.png").c_str()), 0);
  EXPECT_EQ(png.format, static_cast<png_uint_32>(PNG_FORMAT_RGB));
  png.format = PNG_FORMAT_RGB;
  std::uint8_t bytes[18] = {};
  ASSERT_NE(png_image_finish_read(&png, nullptr, bytes, 0, nullptr), 0);
  const std::uint8_t expected[18] = {0, 0, 0, 200, 100, 50, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3};
  EXPECT_EQ(std::memcmp(bytes, expected, sizeof(bytes)), 0);
}

TEST(ImageIo, PfmGivesBackTheSameBitsAndStoresTheBottomRowFirst) {
  const ScratchFolder folder;
  Raster<float> image(3, 2);
  image.samples = {1.5F, -0.0F, 1e-30F, 3e30F, std::numeric_limits<float>::infinity(), 7};
  write_pfm(folder / "d.pfm", image.view());
  const Raster<float> read = read_pfm(folder / "d.pfm");
  ASSERT_EQ(read.width, 3);
  ASSERT_EQ(read.height, 2);
  EXPECT_EQ(std::memcmp(read.samples.data(), image.samples.data(), 6 * sizeof(float)), 0);
  const std::string bytes = text_of(folder / "d.pfm");
  ASSERT_EQ(bytes.substr(0, 12), "Pf\n3 2\n-1.0\n");
  float first = 0;
  std::memcpy(&first, bytes.data() + 12, sizeof(first));
  EXPECT_EQ(first, 3e30F);
}

TEST(ImageIo, FileCutAnywhereIsAnErrorThatNamesIt) {
  const ScratchFolder folder;
  const Raster<std::uint8_t> image = random_image(40, 30);
  Raster<float> depth(40, 30, 2.0F);
  write_png(folder / "a.png", image.view());
  write_pgm(folder / "a.pgm", image.view());
  write_pfm(folder / "a.pfm", depth.view());
  for (const std::string name : {"a.png", "a.pgm", "a.pfm"}) {
    const std::string whole = text_of(folder / name);
    // What follows the last pixel of a PNG (checksums, IEND) may be missing without loss.
    const std::size_t end = whole.size() - (name == "a.png" ? 24 : 0);
    for (std::size_t size = 0; size < end; size += 1 + end / 97) {
      const auto cut = folder.write("cut-" + name, whole.substr(0, size));
      const std::string message = error_of([&] {
        if (name == "a.pfm") {
          (void)read_pfm(cut);
        } else {
          (void)read_gray(cut);
        }
      });
      EXPECT_TRUE(says(message, "cut-" + name)) << size << " bytes of " << whole.size();
    }
  }
}

TEST(ImageIo, DamagedPixelDataOfAPngIsAnError) {
  const ScratchFolder folder;
  const Raster<std::uint8_t> image = random_image(40, 30);
  write_png(folder / "a.png", image.view());
  std::string bytes = text_of(folder / "a.png");
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 0x55);
  EXPECT_TRUE(says(error_of([&] { (void)read_gray(folder.write("bad.png", bytes)); }), "damaged PNG"));
}

TEST(ImageIo, HeadersThatAskForTooMuchMemoryAreRefused) {
  const ScratchFolder folder;
  const auto message = [&](const std::string& name, const std::string& text) {
    return error_of([&] { (void)read_gray(folder.write(name, text)); });
  };
  EXPECT_TRUE(says(message("wide.png", png_of_size(60000, 10)), "60000x10"));
  EXPECT_TRUE(says(message("vast.png", png_of_size(32000, 32000)), "32000x32000"));
  EXPECT_TRUE(says(message("vast.pgm", "P5 32000 32000 255\nx"), "ends early"));
  EXPECT_TRUE(says(message("wide.pgm", "P5 99999999999 2 255\nx"), "malformed PGM header"));
  EXPECT_TRUE(says(error_of([&] { (void)read_pfm(folder.write("v.pfm", "Pf\n32000 32000\n-1.0\nx")); }), "ends early"));
}

TEST(ImageIo, WrongFormatsAreNamed) {
  const ScratchFolder folder;
  const auto message = [&](const std::string& text) {
    return error_of([&] { (void)read_gray(folder.write("f", text)); });
  };
  EXPECT_TRUE(says(message("GIF89a"), "neither PNG nor binary PGM"));
  EXPECT_TRUE(says(message("P2\n1 1\n255\n7\n"), "neither PNG nor binary PGM"));
  EXPECT_TRUE(says(message("P5 1 1 65535\nxx"), "65535"));
  EXPECT_TRUE(says(message("P5 0 1 255\nxx"), "malformed PGM header"));
  EXPECT_TRUE(says(error_of([&] { (void)read_gray(folder / "nowhere.png"); }), "cannot be read"));
  EXPECT_TRUE(says(error_of([&] { (void)read_pfm(folder.write("c.pfm", "PF\n1 1\n-1.0\nabcdabcdabcd")); }),
                   "one-channel little-endian"));
  EXPECT_TRUE(says(error_of([&] { (void)read_pfm(folder.write("b.pfm", "Pf\n1 1\n1.0\nabcd")); }),
                   "one-channel little-endian"));
}

TEST(ImageIo, PgmHeaderMayHoldComments) {
  const ScratchFolder folder;
  const Raster<std::uint8_t> read =
      read_gray(folder.write("c.pgm", "P5 # of netpbm\n# 9 9\n2 1\n# max\n255\n\x23\x0a"));
  ASSERT_EQ(read.width, 2);
  ASSERT_EQ(read.height, 1);
  EXPECT_EQ(read.at(0, 0), 0x23);
  EXPECT_EQ(read.at(1, 0), 0x0a);
}

TEST(ImageIo, CameraHookDecodesBothFormatsAndReturnsWhatIsWrong) {
  const ScratchFolder folder;
  const auto frame = std::make_unique<FrameImage>();
  const Raster<std::uint8_t> image = random_image(80, 64);
  write_png(folder / "a.png", image.view());
  write_pgm(folder / "a.pgm", image.view());
  for (const char* name : {"a.png", "a.pgm"}) {
    ASSERT_TRUE(decode_image((folder / name).c_str(), *frame).ok()) << name;
    ASSERT_EQ(frame->width(), 80);
    ASSERT_EQ(frame->height(), 64);
    EXPECT_EQ(std::memcmp(frame->view().data, image.samples.data(), image.samples.size()), 0) << name;
  }
  EXPECT_EQ(decode_image((folder / "none.png").c_str(), *frame).code, StatusCode::not_found);
  const std::string whole = text_of(folder / "a.png");
  EXPECT_EQ(decode_image(folder.write("cut.png", whole.substr(0, 900)).c_str(), *frame).code, StatusCode::parse_error);
  const Status large = decode_image(folder.write("large.png", png_of_size(9000, 8000)).c_str(), *frame);
  EXPECT_EQ(large.code, StatusCode::image_too_large);
  EXPECT_EQ(large.a, 9000);
  EXPECT_EQ(large.b, 8000);
}

}  // namespace
}  // namespace ilp::host
