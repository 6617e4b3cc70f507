// From the bytes of a video device to grey values.
#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <memory>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "hal/camera/camera.hpp"
#include "hal/camera/v4l2/grey_picture.hpp"
#include "tests/unit/hal/expect_status.hpp"

namespace ilp {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Values = std::vector<std::vector<int>>;  // [y][x]

/// The bytes of a row, written by the kernel's description of each format; 0xA5 where the flight must not look.
Bytes packed(const PixelFormat& format, const std::vector<int>& row) {
  Bytes bytes;
  const auto byte = [&bytes](int value) { bytes.push_back(static_cast<std::uint8_t>(value)); };
  const auto value = [&row](std::size_t x) { return x < row.size() ? row[x] : 0; };
  const std::string name = format.name;
  const bool after_chroma = name == "UYVY" || name == "VYUY";
  const bool with_chroma = after_chroma || name == "YUYV" || name == "YVYU";
  const std::size_t group = name.back() != 'P' || name == "YUV422P" ? 1 : format.bits == 10 ? 4 : 2;
  for (std::size_t x = 0; x < row.size(); x += group) {
    if (group > 1) {
      int low = 0;
      for (std::size_t i = 0; i < group; ++i) {
        byte(value(x + i) >> (format.bits - 8));
        low |= (value(x + i) & ((1 << (format.bits - 8)) - 1)) << (static_cast<int>(i) * (format.bits - 8));
      }
      byte(low);
    } else if (format.bits > 8) {
      byte(value(x) % 256);
      byte(value(x) / 256);
    } else {
      if (after_chroma) byte(0xA5);
      byte(value(x));
      if (with_chroma && !after_chroma) byte(0xA5);
    }
  }
  return bytes;
}

Bytes packed(const PixelFormat& format, const Values& values, std::size_t padding) {
  Bytes bytes;
  for (const std::vector<int>& row : values) {
    const Bytes one = packed(format, row);
    bytes.insert(bytes.end(), one.begin(), one.end());
    if (&row != &values.back()) bytes.insert(bytes.end(), padding, 0xA5);
  }
  return bytes;
}

class PixelFormats : public testing::Test {
 protected:
  [[nodiscard]] Status convert(const PixelFormat& format, const Bytes& bytes, std::int32_t width, std::int32_t height,
                               std::size_t stride) {
    Reduction reduction;
    ILP_TRY(find_reduction(width, height, reduction));
    ILP_TRY(image->resize(reduction.width, reduction.height));
    return converter->convert({format, bytes, width, height, stride}, reduction, image->view());
  }
  [[nodiscard]] Status convert(const PixelFormat& format, const Values& values, std::size_t padding = 0) {
    const Bytes bytes = packed(format, values, padding);
    return convert(format, bytes, static_cast<std::int32_t>(values[0].size()), static_cast<std::int32_t>(values.size()),
                   packed(format, values[0]).size() + padding);
  }
  [[nodiscard]] int at(std::size_t x, std::size_t y) const {
    return image->view().at(static_cast<std::int32_t>(x), static_cast<std::int32_t>(y));
  }

  std::unique_ptr<GreyConverter> converter = std::make_unique<GreyConverter>();
  std::unique_ptr<FrameImage> image = std::make_unique<FrameImage>();
};

std::vector<PixelFormat> raw_formats() {
  std::vector<PixelFormat> formats;
  for (const PixelFormat& format : pixel_formats()) {
    if (format.packing != Packing::jpeg) formats.push_back(format);
  }
  return formats;
}

Values random_values(int bits, std::size_t width, std::size_t height) {
  std::mt19937 random(5);
  Values values(height, std::vector<int>(width));
  for (auto& row : values) {
    for (int& value : row) value = static_cast<int>(random() >> (32 - bits));
  }
  return values;
}

/// The sum of the cell of 2 x 2 pixels whose upper left one is (x, y), with mirrored borders.
int cell(const Values& values, int x, int y) {
  const auto mirrored = [](int i, std::size_t size) {
    const int last = static_cast<int>(size) - 1;
    return static_cast<std::size_t>(i < 0 ? -i : i > last ? 2 * last - i : i);
  };
  int sum = 0;
  for (int i = 0; i < 4; ++i) sum += values[mirrored(y + i / 2, values.size())][mirrored(x + i % 2, values[0].size())];
  return sum;
}

TEST_F(PixelFormats, EveryFormatGivesTheGreyValuesOfItsDescription) {
  for (const PixelFormat& format : raw_formats()) {
    for (const auto& [width, height] : {std::pair<std::size_t, std::size_t>{66, 40}, {5, 3}, {2, 2}}) {
      const Values values = random_values(format.bits, width, height);
      ASSERT_OK(convert(format, values, 7)) << format.name;
      for (std::size_t y = 0; y < height; ++y) {
        for (std::size_t x = 0; x < width; ++x) {
          const int u = static_cast<int>(x), v = static_cast<int>(y);
          const int cells =
              cell(values, u - 1, v - 1) + cell(values, u, v - 1) + cell(values, u - 1, v) + cell(values, u, v);
          const int scale = 1 << (format.bits - 8);
          ASSERT_EQ(at(x, y), format.mosaic ? cells / (16 * scale) : values[y][x] / scale)
              << format.name << " at " << x << ", " << y;
        }
      }
    }
  }
}

// Colour of one kind must not leave a pattern of the mosaic in the image, in whatever order its pixels stand.
TEST_F(PixelFormats, AMosaicOfOneColourIsUniform) {
  for (const PixelFormat& format : raw_formats()) {
    if (!format.mosaic) continue;
    const std::string order = std::string(format.name).substr(1, 4);
    const int scale = 1 << (format.bits - 8);
    Values values(34, std::vector<int>(50));
    for (std::size_t y = 0; y < values.size(); ++y) {
      for (std::size_t x = 0; x < values[0].size(); ++x) {
        const char colour = order[y % 2 * 2 + x % 2];
        values[y][x] = (colour == 'R' ? 200 : colour == 'G' ? 120 : 40) * scale;
      }
    }
    ASSERT_OK(convert(format, values));
    for (std::size_t y = 0; y < values.size(); ++y) {
      for (std::size_t x = 0; x < values[0].size(); ++x) ASSERT_EQ(at(x, y), (200 + 2 * 120 + 40) / 4) << format.name;
    }
  }
}

// A ramp keeps its place: the filter moves nothing by a part of a pixel.
TEST_F(PixelFormats, AMosaicOfARampIsTheRamp) {
  const PixelFormat& format = *find_pixel_format("SRGGB12P");
  Values values(30, std::vector<int>(40));
  for (std::size_t y = 0; y < values.size(); ++y) {
    for (std::size_t x = 0; x < values[0].size(); ++x) values[y][x] = static_cast<int>(37 * x + 53 * y);
  }
  ASSERT_OK(convert(format, values));
  for (std::size_t y = 1; y + 1 < values.size(); ++y) {
    for (std::size_t x = 1; x + 1 < values[0].size(); ++x) ASSERT_EQ(at(x, y), values[y][x] / 16);
  }
}

TEST_F(PixelFormats, HighBitsAreKeptAndBadOnesSaturate) {
  const auto grey = [this](const char* format, int value) {
    EXPECT_OK(convert(*find_pixel_format(format), Values(2, std::vector<int>(2, value))));
    return at(0, 0);
  };
  for (int g = 0; g < 256; ++g) {
    for (const int low : {0, 1, 3}) EXPECT_EQ(grey("Y10", g * 4 + low), g);
    for (const int low : {0, 7, 15}) EXPECT_EQ(grey("Y12", g * 16 + low), g);
    for (const int low : {0, 128, 255}) EXPECT_EQ(grey("Y16", g * 256 + low), g);
  }
  EXPECT_EQ(grey("Y10", 1024), 255);
  EXPECT_EQ(grey("Y12", 0xFFFF), 255);
  EXPECT_EQ(grey("SRGGB10", 0xFFFF), 255) << "a pixel beyond its bits must not overflow into a dark one";
  EXPECT_EQ(grey("SRGGB16", 0xFFFF), 255);
}

TEST_F(PixelFormats, LargePicturesAreReduced) {
  const std::int32_t width = 4 * limits::max_image_width, height = 4 * limits::max_image_height;
  Bytes bytes(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (std::size_t i = 0; i < bytes.size(); ++i)
    bytes[i] = static_cast<std::uint8_t>(i % static_cast<std::size_t>(width) / 16);
  if (width > limits::max_sensor_side || height > limits::max_sensor_side) GTEST_SKIP() << "no sensor is so large";
  ASSERT_OK(convert(*find_pixel_format("NV12"), bytes, width, height, static_cast<std::size_t>(width)));
  ASSERT_EQ(image->width(), limits::max_image_width);
  for (const std::size_t x : {std::size_t{0}, std::size_t{99}, std::size_t{639}})
    EXPECT_EQ(at(x, 17), static_cast<int>(x / 4 % 256));
}

TEST_F(PixelFormats, BytesThatDoNotSufficeAreRefused) {
  for (const PixelFormat& format : raw_formats()) {
    const std::size_t row = row_bytes(format, 64);
    const Bytes bytes(row * 63 + row);
    ASSERT_OK(convert(format, bytes, 64, 64, row)) << format.name;
    EXPECT_STATUS(convert(format, Bytes(bytes.size() - 1), 64, 64, row), camera_layout) << format.name;
    EXPECT_STATUS(convert(format, bytes, 64, 64, row - 1), camera_layout) << format.name;
    EXPECT_STATUS(convert(format, bytes, 64, 64, row + 1), camera_layout) << format.name;
    EXPECT_STATUS(convert(format, bytes, 64, 64, ~std::size_t{0}), camera_layout) << format.name;
    EXPECT_STATUS(convert(format, {}, 64, 64, row), camera_layout) << format.name;
    Reduction reduction;
    ASSERT_OK(find_reduction(64, 64, reduction));
    for (const std::int32_t side : {0, 1, -64, limits::max_sensor_side + 1, INT32_MAX, INT32_MIN}) {
      EXPECT_FALSE(converter->convert({format, bytes, side, 64, row}, reduction, image->view()).ok()) << side;
      EXPECT_FALSE(converter->convert({format, bytes, 64, side, row}, reduction, image->view()).ok()) << side;
    }
  }
}

TEST_F(PixelFormats, AreFoundByNameAndByCode) {
  EXPECT_EQ(find_pixel_format("SRGGB10P")->fourcc, V4L2_PIX_FMT_SRGGB10P);
  EXPECT_EQ(find_pixel_format("pRAA")->fourcc, V4L2_PIX_FMT_SRGGB10P);
  EXPECT_EQ(find_pixel_format("MJPG"), find_pixel_format("MJPEG"));
  EXPECT_EQ(find_pixel_format("Y10")->fourcc, V4L2_PIX_FMT_Y10) << "its code ends in a blank";
  EXPECT_EQ(find_pixel_format("RGB3"), nullptr);
  EXPECT_EQ(find_pixel_format(""), nullptr);
  EXPECT_STREQ(fourcc_text(V4L2_PIX_FMT_Y16).text, "Y16");
  EXPECT_STREQ(fourcc_text(0x01FFFF41).text, "A???");
  std::set<std::string> names;
  for (const PixelFormat& format : pixel_formats()) EXPECT_TRUE(names.insert(format.name).second) << format.name;
}

}  // namespace
}  // namespace ilp
