// Pictures that are larger than the flight's images: what of them is kept, and the camera of the result.
#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <vector>

#include "hal/camera/camera.hpp"
#include "hal/camera/picture/reduction.hpp"
#include "tests/unit/hal/expect_status.hpp"

namespace ilp {
namespace {

constexpr std::int32_t widest = limits::max_image_width, highest = limits::max_image_height;

struct Sensor {
  std::int32_t width, height;
};
constexpr Sensor sensors[] = {{640, 480},   {800, 600},   {1024, 768},  {1280, 720},  {1296, 972},
                              {1640, 1232}, {1920, 1080}, {2592, 1944}, {3040, 4056}, {3280, 2464},
                              {4056, 3040}, {4608, 2592}, {1025, 100},  {2048, 2048}};

TEST(Reduction, APictureThatFitsStaysAsItIs) {
  for (const auto& [width, height] : {Sensor{widest, highest}, Sensor{64, 64}, Sensor{widest, 1}, Sensor{1, 1}}) {
    Reduction reduction;
    ASSERT_OK(find_reduction(width, height, reduction));
    EXPECT_TRUE(reduction.changes_nothing());
    EXPECT_EQ(reduction.width, width);
    EXPECT_EQ(reduction.height, height);
  }
}

TEST(Reduction, IsTheFinestThatKeepsNineTenthsOfBothSides) {
  const auto keeps = [](std::int32_t side, std::int32_t most, std::int32_t factor) {
    return static_cast<double>(std::min(side / factor, most) * factor) >= 0.9 * side;
  };
  for (const auto& [width, height] : sensors) {
    Reduction r;
    ASSERT_OK(find_reduction(width, height, r)) << width << " x " << height;
    EXPECT_TRUE(r.width <= widest && r.height <= highest && r.factor >= 1 && r.left >= 0 && r.top >= 0);
    EXPECT_LE(r.left + r.factor * r.width, width);
    EXPECT_LE(r.top + r.factor * r.height, height);
    // The middle stays the middle, to a pixel of the picture.
    EXPECT_LE(std::abs(2 * r.left + r.factor * r.width - width), 1);
    EXPECT_LE(std::abs(2 * r.top + r.factor * r.height - height), 1);
    EXPECT_TRUE(keeps(width, widest, r.factor) && keeps(height, highest, r.factor));
    for (std::int32_t finer = 1; finer < r.factor; ++finer) {
      EXPECT_FALSE(keeps(width, widest, finer) && keeps(height, highest, finer)) << width << " x " << height;
    }
  }
}

TEST(Reduction, OfKnownSensorsIsAsThePageSays) {
  const bool flight = widest == 640;
  const auto expect = [](Sensor sensor, std::int32_t factor, std::int32_t width, std::int32_t height) {
    Reduction r;
    ASSERT_OK(find_reduction(sensor.width, sensor.height, r));
    EXPECT_TRUE(r.factor == factor && r.width == width && r.height == height)
        << sensor.width << " x " << sensor.height << ": " << r.factor << ", " << r.width << " x " << r.height;
  };
  expect({1280, 720}, 2, 640, 360);
  if (!flight) return;
  expect({1920, 1080}, 3, 640, 360);
  expect({1640, 1232}, 3, 546, 410);
  expect({2592, 1944}, 4, 640, 480);
  expect({3280, 2464}, 5, 640, 480);
  expect({4056, 3040}, 6, 640, 480);
  expect({4608, 2592}, 7, 640, 370);
}

TEST(Reduction, SizesBeyondTheSensorLimitAndStripesAreRefused) {
  Reduction r;
  EXPECT_STATUS(find_reduction(limits::max_sensor_side + 1, 480, r), image_too_large);
  EXPECT_STATUS(find_reduction(640, limits::max_sensor_side + 1, r), image_too_large);
  EXPECT_STATUS(find_reduction(0, 480, r), image_too_large);
  EXPECT_STATUS(find_reduction(640, -1, r), image_too_large);
  EXPECT_STATUS(find_reduction(limits::max_sensor_side, 1, r), image_too_large) << "no pixel of height would be left";
}

// A pixel of the image looks into the mean direction of the pixels that it was made from.
TEST(Reduction, TheCameraOfTheImageSeesTheSameDirections) {
  for (const auto& [width, height] : sensors) {
    Reduction r;
    ASSERT_OK(find_reduction(width, height, r));
    const CameraModel camera{width, height, 1.1 * width, 1.2 * width, 0.48 * width, 0.53 * height, -0.1, 0.02, 1e-3, 0};
    const CameraModel reduced = reduced_camera(camera, r);
    EXPECT_EQ(reduced.width, r.width);
    EXPECT_EQ(reduced.height, r.height);
    EXPECT_EQ(reduced.k1, camera.k1);
    EXPECT_EQ(reduced.p1, camera.p1);
    for (const std::int32_t x : {0, 7, r.width - 1}) {
      double middle = 0;
      for (std::int32_t i = 0; i < r.factor; ++i) middle += static_cast<double>(r.left + r.factor * x + i) / r.factor;
      EXPECT_NEAR((x - reduced.cx) / reduced.fx, (middle - camera.cx) / camera.fx, 1e-12);
    }
    for (const std::int32_t y : {0, 5, r.height - 1}) {
      double middle = 0;
      for (std::int32_t i = 0; i < r.factor; ++i) middle += static_cast<double>(r.top + r.factor * y + i) / r.factor;
      EXPECT_NEAR((y - reduced.cy) / reduced.fy, (middle - camera.cy) / camera.fy, 1e-12);
    }
  }
}

TEST(Reduction, PixelsAreRoundedMeans) {
  auto image = std::make_unique<FrameImage>();
  auto reducer = std::make_unique<RowReducer>();
  std::mt19937 random(3);
  for (const auto& [width, height] : {Sensor{1920, 1080}, Sensor{1285, 725}, Sensor{widest + 3, 70}}) {
    std::vector<std::uint8_t> picture(static_cast<std::size_t>(width * height));
    for (std::uint8_t& pixel : picture) pixel = static_cast<std::uint8_t>(random());
    Reduction r;
    ASSERT_OK(find_reduction(width, height, r));
    ASSERT_OK(image->resize(r.width, r.height));
    reducer->begin(r, image->view());
    const auto row_size = static_cast<std::size_t>(width);
    for (std::size_t y = 0; y < static_cast<std::size_t>(height) + 2; ++y) {
      reducer->add(y < static_cast<std::size_t>(height) ? std::span(picture).subspan(y * row_size, row_size)
                                                        : std::span<std::uint8_t>());
    }
    for (std::int32_t y = 0; y < r.height; ++y) {
      for (std::int32_t x = 0; x < r.width; ++x) {
        int sum = 0;
        for (std::int32_t i = 0; i < r.factor * r.factor; ++i) {
          const std::int32_t px = r.left + r.factor * x + i % r.factor, py = r.top + r.factor * y + i / r.factor;
          sum += picture[static_cast<std::size_t>(py * width + px)];
        }
        const double mean = static_cast<double>(sum) / (r.factor * r.factor);
        ASSERT_EQ(image->view().at(x, y), static_cast<int>(mean + 0.5)) << x << ", " << y;
      }
    }
  }
}

}  // namespace
}  // namespace ilp
