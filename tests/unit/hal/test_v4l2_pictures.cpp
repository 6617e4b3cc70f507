// Pictures of today's cameras through the V4L2 camera: compressed, raw, and larger than the flight's images.
#include <algorithm>

#include "tests/support/jpeg_file.hpp"
#include "tests/unit/hal/v4l2_flight.hpp"

namespace ilp {
namespace {

using test::jpeg_file;
using test::V4l2Flight;

std::uint8_t tiles(std::int32_t x, std::int32_t y) {
  return static_cast<std::uint8_t>(x / 8 * 37 + y / 8 * 91 + 5);
}

class V4l2Pictures : public V4l2Flight {
 protected:
  void SetUp() override {
    every_frame = true;
    device.formats = {V4L2_PIX_FMT_MJPEG};
  }
  /// A camera that sends JPEG files, whose picture differs from frame to frame.
  void send_jpeg() {
    device.whole_picture = [](std::int64_t number, const v4l2_pix_format& format, std::vector<std::uint8_t>& bytes) {
      const auto luma = [number](std::int32_t x, std::int32_t y) {
        return static_cast<std::uint8_t>(tiles(x, y) + number % 7);
      };
      const auto file = jpeg_file(static_cast<std::int32_t>(format.width), static_cast<std::int32_t>(format.height),
                                  luma, {.horizontal = 2, .vertical = 1, .standard_tables_left_out = true});
      std::fill(bytes.begin(), bytes.end(), std::uint8_t{0});
      std::copy(file.begin(), file.end(), bytes.begin());
    };
  }
  Status prepare_size(std::int32_t w, std::int32_t h) {
    ILP_TRY(camera->configure(options, w, h, test::ScriptedVideoDevice::mission_minus_monotonic));
    return camera->prepare(5 * ns_per_s);
  }
};

TEST_F(V4l2Pictures, JpegBecomesGrey) {
  send_jpeg();
  ASSERT_OK(prepare());
  EXPECT_STREQ(camera->format().pixel.name, "MJPEG");
  EXPECT_EQ(camera->verdict().findings, 0U);
  fly(0.3);
  ASSERT_FALSE(given.empty());
  const int first = image->view().at(0, 0) - tiles(0, 0);
  EXPECT_TRUE(first >= 0 && first < 7);
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) ASSERT_EQ(image->view().at(x, y), (tiles(x, y) + first) & 255);
  }
  EXPECT_TRUE(events_of(StatusCode::camera_frames_refused).empty());
}

TEST_F(V4l2Pictures, DamagedJpegIsReportedAndAnotherFrameIsTheAnswer) {
  send_jpeg();
  ASSERT_OK(prepare());
  every_frame = false;
  take(clock.now());
  // Each second frame ends early, as after a lost transfer.
  device.spoil = [](test::ScriptedVideoDevice::Frame& frame) {
    if (frame.number % 2 == 0) frame.buffer.bytesused = 700;
  };
  for (int i = 0; i < 40; ++i) take(clock.now());
  EXPECT_EQ(given.size(), 41U) << "a wanted time is within a period of a valid frame";
  ASSERT_FALSE(events_of(StatusCode::camera_frames_refused).empty());
  EXPECT_EQ(events_of(StatusCode::camera_frames_refused).front().b, 4);
  EXPECT_TRUE(events_of(StatusCode::camera_fault).empty());
}

TEST_F(V4l2Pictures, AJpegCameraThatSendsSomethingElseGivesNothing) {
  device.whole_picture = [](std::int64_t number, const v4l2_pix_format&, std::vector<std::uint8_t>& bytes) {
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(number + 31 * i);
  };
  EXPECT_FALSE(prepare().ok());
  fly(12);
  EXPECT_TRUE(given.empty());
  ASSERT_FALSE(events_of(StatusCode::camera_frames_refused).empty());
}

TEST_F(V4l2Pictures, PackedBayerBecomesGrey) {
  device.formats = {V4L2_PIX_FMT_SRGGB10P};
  // A ramp of 10 bits in the mosaic stays a ramp.
  device.whole_picture = [](std::int64_t, const v4l2_pix_format& format, std::vector<std::uint8_t>& bytes) {
    for (std::size_t y = 0; y < format.height; ++y) {
      for (std::size_t x = 0; x < format.width; ++x) {
        const std::size_t value = 8 * x + 4 * y;
        std::uint8_t* const group = bytes.data() + y * format.bytesperline + x / 4 * 5;
        group[x % 4] = static_cast<std::uint8_t>(value / 4);
        group[4] = 0;
      }
    }
  };
  device.stride_padding = 12;
  ASSERT_OK(prepare());
  EXPECT_STREQ(camera->format().pixel.name, "SRGGB10P");
  fly(0.3);
  ASSERT_FALSE(given.empty());
  for (std::int32_t y = 1; y + 1 < height; ++y) {
    for (std::int32_t x = 1; x + 1 < width; ++x) ASSERT_EQ(image->view().at(x, y), 2 * x + y);
  }
}

TEST_F(V4l2Pictures, ASensorLargerThanTheImageIsReduced) {
  device.formats = {V4L2_PIX_FMT_NV12};
  const std::int32_t w = 2 * limits::max_image_width, h = 720;
  device.picture = [](std::int64_t, std::int32_t x, std::int32_t y) {
    return static_cast<std::uint8_t>(x / 16 + y / 16);
  };
  ASSERT_OK(prepare_size(w, h));
  fly(0.3);
  ASSERT_FALSE(given.empty());
  EXPECT_EQ(camera->reduction().factor, 2);
  ASSERT_EQ(image->width(), limits::max_image_width);
  ASSERT_EQ(image->height(), h / 2);
  for (std::int32_t y = 0; y < h / 2; ++y) {
    for (std::int32_t x = 0; x < limits::max_image_width; ++x)
      ASSERT_EQ(image->view().at(x, y), x / 8 + y / 8) << x << ", " << y;
  }
}

TEST_F(V4l2Pictures, TheFormatThatHasTheSizeIsTaken) {
  device.formats = {V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_NV12};
  device.sizes[V4L2_PIX_FMT_YUYV] = {64, 64};
  ASSERT_OK(prepare());
  EXPECT_STREQ(camera->format().pixel.name, "NV12");
  device.sizes[V4L2_PIX_FMT_NV12] = {96, 64};
  camera = std::make_unique<V4l2Camera>(device, clock);
  const Status status = prepare();
  EXPECT_STATUS(status, camera_size);
  EXPECT_EQ(status.b, 6400064) << "that of the first format";
}

TEST_F(V4l2Pictures, ADeviceThatListsNoFormatsIsAskedForEach) {
  device.formats = {V4L2_PIX_FMT_SRGGB8};
  device.lists_formats = false;
  ASSERT_OK(prepare());
  EXPECT_STREQ(camera->format().pixel.name, "SRGGB8");
}

TEST_F(V4l2Pictures, ADeviceIsAskedOnlyForWhatItLists) {
  device.formats = {V4L2_PIX_FMT_SRGGB8};
  ASSERT_OK(prepare());
  EXPECT_EQ(device.requests[VIDIOC_S_FMT], 1);
}

}  // namespace
}  // namespace ilp
