// What is agreed with a video device, and how its pixels become grey values.
#include <array>

#include "tests/unit/hal/v4l2_flight.hpp"

namespace ilp {
namespace {

using test::V4l2Flight;

class V4l2FormatTest : public V4l2Flight {
 protected:
  [[nodiscard]] Status option(const char* text) { return parse_v4l2_options(text, options); }
  [[nodiscard]] std::vector<std::int64_t> latest_values(StatusCode code) const {
    const auto found = events_of(code);
    if (found.empty()) return {};
    return {found.back().a, found.back().b};
  }
};

using Values = std::vector<std::int64_t>;

TEST(V4l2Options, AreReadFromText) {
  V4l2Options options;
  ASSERT_OK(parse_v4l2_options("/dev/v4l/by-path/pci-0000:00:14.0-video-index0", options));
  EXPECT_STREQ(options.device, "/dev/v4l/by-path/pci-0000:00:14.0-video-index0");
  EXPECT_EQ(options.format, nullptr);
  ASSERT_OK(parse_v4l2_options("/dev/video0,format=Y10,rate=12.5,input=1,exposure_us=5000,gain=12,stamp_delay_us=0",
                               options));
  EXPECT_STREQ(options.format->name, "Y10");
  EXPECT_EQ(options.rate_mhz, 12'500);
  EXPECT_EQ(options.input, 1);
  EXPECT_EQ(options.exposure_us, 5000);
  EXPECT_EQ(options.gain, 12);
  EXPECT_EQ(options.stamp_delay_us, 0);
}

TEST(V4l2Options, WhatIsNotUnderstoodIsNamed) {
  V4l2Options options;
  for (const char* text : {"", ",format=GREY", "/dev/video0,format=RGB3", "/dev/video0,rate=0", "/dev/video0,rate=x",
                           "/dev/video0,gain", "/dev/video0,colour=1", "/dev/video0,gain=1x", "/dev/video0,",
                           "/dev/video0,gain=12345678901", "/dev/video0,format=", "/dev/video0,,gain=1"}) {
    EXPECT_STATUS(parse_v4l2_options(text, options), parse_error) << text;
  }
  EXPECT_EQ(parse_v4l2_options("/dev/video0,gain=x", options).a, 17);
  const std::string deep = "/" + std::string(2000, 'x');
  EXPECT_STATUS(parse_v4l2_options(deep.c_str(), options), capacity_exceeded);
}

TEST(V4l2Size, IsThatToWhichTheDeviceIsSet) {
  VirtualClock clock;
  test::ScriptedVideoDevice device(clock);
  V4l2Options options;
  ASSERT_OK(parse_v4l2_options("/dev/video0", options));
  device.width = 800;
  device.height = 600;
  std::int32_t width = 0, height = 0;
  ASSERT_OK(present_size(device, options, width, height));
  EXPECT_EQ(width, 800);
  EXPECT_EQ(height, 600);
  device.failures[VIDIOC_G_FMT] = {EIO};
  EXPECT_STATUS(present_size(device, options, width, height), camera_fault);
  device.present = false;
  EXPECT_STATUS(present_size(device, options, width, height), camera_absent);
  EXPECT_TRUE(device.misuse.empty()) << "it is closed each time";
}

TEST_F(V4l2FormatTest, TheFirstFormatThatTheCameraHasIsTaken) {
  device.formats = {V4L2_PIX_FMT_RGB24, V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_Y12};
  device.stride_padding = 32;
  device.picture = [](std::int64_t, std::int32_t x, std::int32_t y) { return static_cast<std::uint8_t>(x + 2 * y); };
  ASSERT_OK(prepare());
  EXPECT_STREQ(camera->format().pixel.name, "Y12");
  options.format = find_pixel_format("YUYV");
  camera = std::make_unique<V4l2Camera>(device, clock);
  ASSERT_OK(prepare());
  EXPECT_STREQ(camera->format().pixel.name, "YUYV");
  every_frame = true;
  fly(0.2);
  ASSERT_FALSE(given.empty());
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) ASSERT_EQ(image->view().at(x, y), (x + 2 * y) & 255);
  }
}

TEST_F(V4l2FormatTest, WithoutACommonFormatTheOfferedOneIsNamed) {
  device.formats = {V4L2_PIX_FMT_RGB24};
  const Status status = prepare();
  EXPECT_STATUS(status, unsupported_format);
  EXPECT_EQ(status.a, V4L2_PIX_FMT_RGB24);
}

TEST_F(V4l2FormatTest, AnotherSizeThanAskedIsRefusedWithBothSizes) {
  device.width = 320;
  device.height = 240;
  const Status status = prepare();
  EXPECT_STATUS(status, camera_size);
  EXPECT_EQ(status.a, 8000064);
  EXPECT_EQ(status.b, 32000240);
  device.width = width;
  EXPECT_STATUS(prepare(), camera_size);
}

TEST_F(V4l2FormatTest, SizesBeyondTheLimitsAreRefused) {
  EXPECT_STATUS(camera->configure(options, limits::max_sensor_side + 1, 100, 0), image_too_large);
  EXPECT_STATUS(camera->configure(options, 640, -480, 0), image_too_large);
  EXPECT_STATUS(camera->configure(options, 1, 1, 0), image_too_large);
}

TEST_F(V4l2FormatTest, RowsAndPicturesThatCannotBeAreRefused) {
  device.stated_stride_change = static_cast<std::uint32_t>(-1);
  EXPECT_STATUS(prepare(), camera_layout);
  device.stated_stride_change = 0x7000'0000;
  EXPECT_STATUS(prepare(), camera_layout);
  device.stated_stride_change = 0;
  device.stated_size_change = static_cast<std::uint32_t>(-1);
  EXPECT_STATUS(prepare(), camera_layout);
  device.stated_size_change = 0;
  device.length_change = static_cast<std::uint32_t>(-1);
  EXPECT_STATUS(prepare(), camera_layout);
}

TEST_F(V4l2FormatTest, ADeviceThatIsNoCameraIsRefused) {
  device.capabilities = V4L2_CAP_VIDEO_OUTPUT | V4L2_CAP_STREAMING;
  EXPECT_STATUS(prepare(), camera_incapable);
  device.capabilities = V4L2_CAP_VIDEO_CAPTURE;
  EXPECT_STATUS(prepare(), camera_incapable);
}

TEST_F(V4l2FormatTest, TooFewOrTooManyBuffersAreRefused) {
  device.most_buffers = 1;
  EXPECT_STATUS(prepare(), camera_buffers);
  device.most_buffers = 32;
  device.least_buffers = limits::max_camera_buffers + 1;
  EXPECT_STATUS(prepare(), camera_buffers);
}

TEST_F(V4l2FormatTest, AnotherRateIsToldOnce) {
  options.rate_mhz = 10'000;
  ASSERT_OK(prepare());
  fly(1);
  EXPECT_EQ(events_of(StatusCode::camera_rate).size(), 1U);
  EXPECT_EQ(latest_values(StatusCode::camera_rate), (Values{10'000, 25'000}));
}

TEST_F(V4l2FormatTest, ADeviceWithoutARateIsMeasured) {
  device.states_rate = false;
  ASSERT_OK(prepare());
  EXPECT_EQ(camera->verdict().findings, 0U);
  EXPECT_EQ(camera->verdict().period_ns, device.period_ns);
}

TEST_F(V4l2FormatTest, ExposureAndGainStayInTheDriversRange) {
  device.controls[V4L2_CID_EXPOSURE_AUTO] = {0, 3, 1, V4L2_EXPOSURE_AUTO};
  device.controls[V4L2_CID_EXPOSURE_ABSOLUTE] = {1, 100, 1, 80};
  device.controls[V4L2_CID_GAIN] = {0, 60, 8, 0};
  ASSERT_OK(option("/dev/video0,exposure_us=5000,gain=99"));
  ASSERT_OK(prepare());
  fly(1);
  EXPECT_EQ(device.controls[V4L2_CID_EXPOSURE_AUTO].value, V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(device.controls[V4L2_CID_EXPOSURE_ABSOLUTE].value, 50);
  EXPECT_EQ(device.controls[V4L2_CID_GAIN].value, 56);
  EXPECT_EQ(events_of(StatusCode::camera_control_limited).size(), 1U);
  EXPECT_EQ(latest_values(StatusCode::camera_control_limited), (Values{V4L2_CID_GAIN, 56}));
}

TEST_F(V4l2FormatTest, AMissingControlIsToldAndTheFlightGoesOn) {
  ASSERT_OK(option("/dev/video0,exposure_us=5000"));
  ASSERT_OK(prepare());
  fly(1);
  EXPECT_EQ(latest_values(StatusCode::camera_control_missing), (Values{V4L2_CID_EXPOSURE_ABSOLUTE, 0}));
}

}  // namespace
}  // namespace ilp
