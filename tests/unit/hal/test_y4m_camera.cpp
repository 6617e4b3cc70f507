// YUV4MPEG2 streams: header, planes, times, and streams that break off.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <limits>
#include <memory>
#include <string>
#include <tuple>

#include "fsw/base/status_values.hpp"
#include "hal/camera/y4m/y4m_camera.hpp"
#include "tests/unit/hal/expect_status.hpp"

namespace ilp {
namespace {

constexpr TimeNs late = 1'000'000'000'000'000;

class Y4mCameraTest : public testing::Test {
 protected:
  ~Y4mCameraTest() override {
    if (file_ != nullptr) std::fclose(file_);
  }
  Status open(const std::string& stream) {
    if (file_ != nullptr) std::fclose(file_);
    file_ = std::tmpfile();
    std::fwrite(stream.data(), 1, stream.size(), file_);
    std::fflush(file_);
    lseek(fileno(file_), 0, SEEK_SET);
    return camera_.open(fileno(file_));
  }
  Status capture(TimeNs now = late) { return camera_.capture(now, *image_, frame_); }
  static std::string frame(std::size_t luma, char value, std::size_t chroma, const std::string& parameters = "") {
    return "FRAME" + parameters + "\n" + std::string(luma, value) + std::string(chroma, 'c');
  }

  std::FILE* file_ = nullptr;
  Y4mCamera camera_;
  std::unique_ptr<FrameImage> image_ = std::make_unique<FrameImage>();
  CameraFrame frame_;
};

TEST_F(Y4mCameraTest, TakesTheLumaOfEverySampling) {
  struct Sampling {
    const char* tag;
    std::size_t chroma;
  };
  // 5 x 3: chroma planes round up (yuv4mpeg(5), mjpegtools).
  for (const Sampling& s : {Sampling{"", 12},
                            {" C420", 12},
                            {" C420jpeg", 12},
                            {" C420mpeg2", 12},
                            {" C420paldv", 12},
                            {" C422", 18},
                            {" C444", 30},
                            {" Cmono", 0},
                            {" C411", 12}}) {
    ASSERT_OK(open("YUV4MPEG2 W5 H3 F25:1 Ip A1:1" + std::string(s.tag) + " XCOLORRANGE=FULL\n" +
                   frame(15, 'a', s.chroma) + frame(15, 'b', s.chroma, " Ixyz")))
        << s.tag;
    EXPECT_EQ(camera_.width(), 5);
    EXPECT_EQ(camera_.height(), 3);
    ASSERT_OK(capture()) << s.tag;
    EXPECT_EQ(image_->view().at(4, 2), 'a');
    ASSERT_OK(capture()) << s.tag;
    EXPECT_EQ(image_->view().at(0, 0), 'b');
    EXPECT_EQ(image_->view().at(4, 2), 'b');
    EXPECT_EQ(frame_.sequence, 2);
    EXPECT_STREQ(frame_.name, "frame-000002");
    const Status end = capture();
    EXPECT_EQ(end.code, StatusCode::end_of_stream) << s.tag;
    EXPECT_EQ(end.a, 2);
  }
}

TEST_F(Y4mCameraTest, LargePicturesAreReduced) {
  const int width = 2 * limits::max_image_width, height = 140;
  std::string luma;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) luma += static_cast<char>(x / 16 + y / 2);
  }
  const std::string one = "FRAME\n" + luma + std::string(luma.size() / 2, 'c');
  ASSERT_OK(open("YUV4MPEG2 W" + std::to_string(width) + " H140 F25:1\n" + one + one));
  EXPECT_EQ(camera_.width(), width);
  for (int frame = 0; frame < 2; ++frame) {
    ASSERT_OK(capture());
    ASSERT_EQ(image_->width(), width / 2);
    ASSERT_EQ(image_->height(), height / 2);
    for (std::int32_t y = 0; y < height / 2; ++y) {
      for (std::int32_t x = 0; x < width / 2; ++x) ASSERT_EQ(image_->view().at(x, y), (x / 8 + y) % 256);
    }
  }
  EXPECT_STATUS(capture(), end_of_stream);
}

TEST_F(Y4mCameraTest, TimesFollowFromTheRate) {
  std::string stream = "YUV4MPEG2 W1 H1 F30000:1001 Cmono\n";
  for (int i = 0; i < 100; ++i) stream += frame(1, 'x', 0);
  ASSERT_OK(open(stream));
  ASSERT_OK(capture(0));
  EXPECT_EQ(frame_.time_ns, 0);
  EXPECT_STATUS(capture(33'366'665), not_ready);
  ASSERT_OK(capture(33'366'666));
  EXPECT_EQ(frame_.time_ns, 33'366'666);
  for (int i = 2; i < 100; ++i) ASSERT_OK(capture());
  EXPECT_EQ(frame_.time_ns, 3'303'300'000) << "99 * 1001 / 30000 s";

  stream = "YUV4MPEG2 W1 H1 F1:999999999 Cmono\n";
  for (int i = 0; i < 20; ++i) stream += frame(1, 'x', 0);
  ASSERT_OK(open(stream));
  Status status;
  int frames = 0;
  for (; frames < 30 && status.ok(); ++frames) status = capture(std::numeric_limits<TimeNs>::max());
  EXPECT_EQ(status.code, StatusCode::unsupported_format) << "times beyond 64 bits";
  EXPECT_EQ(frames, 11);
}

TEST_F(Y4mCameraTest, HeadersThatAreNoneOrNotSupported) {
  EXPECT_STATUS(open(""), truncated);
  EXPECT_STATUS(open("YUV4MPEG2 W5 H3 F25:1"), truncated);
  EXPECT_STATUS(open("RIFF....AVI \n"), parse_error);
  EXPECT_STATUS(open("YUV4MPEG2\n"), parse_error);
  EXPECT_STATUS(open("YUV4MPEG2 W5 F25:1\n"), parse_error);
  EXPECT_STATUS(open("YUV4MPEG2 W-5 H3 F25:1\n"), parse_error);
  EXPECT_STATUS(open("YUV4MPEG2 W99999999999999999999 H3 F25:1\n"), parse_error);
  EXPECT_STATUS(open("YUV4MPEG2 " + std::string(100000, 'X') + "\n"), parse_error);
  EXPECT_STATUS(open("YUV4MPEG2 W100000 H3 F25:1\n"), image_too_large);
  EXPECT_STATUS(open("YUV4MPEG2 W5 H3\n"), unsupported_format);
  EXPECT_STATUS(open("YUV4MPEG2 W5 H3 F0:0\n"), unsupported_format);
  EXPECT_STATUS(open("YUV4MPEG2 W5 H3 F25:0\n"), unsupported_format);
  EXPECT_STATUS(open("YUV4MPEG2 W5 H3 F25:1 C420p10\n"), unsupported_format);
  EXPECT_STATUS(open("YUV4MPEG2 W5 H3 F25:1 Cmono16\n"), unsupported_format);
  EXPECT_STATUS(capture(), end_of_stream) << "nothing comes from a stream that was refused";
  EXPECT_OK(open("YUV4MPEG2 W5 H3 F25:1\n"));
}

TEST_F(Y4mCameraTest, DepthRateFieldsAndAspectAreToldApart) {
  const auto fault = [&](const std::string& tags) {
    const Status status = open("YUV4MPEG2 W1 H1" + tags + "\n");
    EXPECT_EQ(status.code, StatusCode::unsupported_format) << tags;
    return static_cast<FormatFault>(status.a);
  };
  for (const auto& [sampling, bits] :
       {std::pair{"C420p10", 10}, {"C422p12", 12}, {"Cmono10", 10}, {"Cmono16", 16}, {"C410", 8}, {"C420paldv2", 8}}) {
    EXPECT_EQ(fault(std::string(" F2:1 ") + sampling), FormatFault::y4m_sampling) << sampling;
    EXPECT_EQ(camera_.bits_per_sample(), bits) << sampling;
  }
  EXPECT_EQ(fault(" Cmono"), FormatFault::y4m_rate);
  EXPECT_EQ(fault(" F0:0 Cmono"), FormatFault::y4m_rate);
  for (const auto& [tags, interlaced, wide] : {std::tuple{" Ip A1:1", false, false},
                                               {" It A0:0", true, false},
                                               {" Ib", true, false},
                                               {" Im A16:11", true, true},
                                               {" I? A2:2", false, false}}) {
    ASSERT_OK(open("YUV4MPEG2 W1 H1 F2:1 Cmono" + std::string(tags) + "\n"));
    EXPECT_EQ(camera_.interlaced(), interlaced) << tags;
    EXPECT_EQ(camera_.pixels_are_wide(), wide) << tags;
  }
}

TEST_F(Y4mCameraTest, ARateMayBeGivenWhereTheHeaderHasNone) {
  const std::string stream = "YUV4MPEG2 W1 H1 F0:0 Cmono\n" + frame(1, 'x', 0) + frame(1, 'y', 0);
  EXPECT_STATUS(open(stream), unsupported_format);
  lseek(fileno(file_), 0, SEEK_SET);
  ASSERT_OK(camera_.open(fileno(file_), {.live = false, .rate = {2, 3}}));
  ASSERT_OK(capture());
  ASSERT_OK(capture());
  EXPECT_EQ(frame_.time_ns, 1'500'000'000);
}

TEST_F(Y4mCameraTest, CommentsOfAnyLengthArePassedOver) {
  const std::string comment = " XCOMMENT=" + std::string(3000, 'I');
  ASSERT_OK(open("YUV4MPEG2 W1 H1" + comment + " F2:1 XB=C420 Cmono\n" + frame(1, 'x', 0, comment) + frame(1, 'y', 0)));
  EXPECT_FALSE(camera_.interlaced());
  ASSERT_OK(capture());
  ASSERT_OK(capture());
  EXPECT_EQ(image_->view().at(0, 0), 'y');
  EXPECT_STATUS(open("YUV4MPEG2 W1 H1 F2:1 X" + std::string(100'000, 'x') + "\n"), parse_error);
}

TEST_F(Y4mCameraTest, WhatEndsAStreamEarlyIsKept) {
  ASSERT_OK(open("YUV4MPEG2 W2 H2 F2:1 C420\n" + frame(4, 'x', 0) + frame(4, 'y', 0)));
  ASSERT_OK(capture());
  EXPECT_FALSE(capture().ok());
  EXPECT_STATUS(camera_.broken(), parse_error) << "the frames have no chroma";
  ASSERT_OK(open("YUV4MPEG2 W2 H2 F2:1 Cmono\n" + frame(4, 'x', 0)));
  ASSERT_OK(capture());
  EXPECT_STATUS(capture(), end_of_stream);
  EXPECT_OK(camera_.broken());
}

TEST_F(Y4mCameraTest, BrokenStreamIsOneStatusAndThenTheEnd) {
  const std::string header = "YUV4MPEG2 W4 H4 F25:1\n";
  const std::string one = frame(16, 'a', 8);
  for (std::size_t size = 1; size < one.size(); ++size) {
    ASSERT_OK(open(header + one + one.substr(0, size)));
    ASSERT_OK(capture());
    EXPECT_STATUS(capture(), truncated) << "after " << size << " bytes of a frame";
    EXPECT_STATUS(capture(), end_of_stream);
  }
  ASSERT_OK(open(header + one + "frame\n" + one));
  ASSERT_OK(capture());
  EXPECT_STATUS(capture(), parse_error);
  EXPECT_STATUS(capture(), end_of_stream);
}

TEST_F(Y4mCameraTest, ReadsFromAPipeAsItFills) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const std::string stream = "YUV4MPEG2 W4 H4 F25:1 Cmono\n" + frame(16, 'a', 0) + frame(16, 'b', 0);
  ASSERT_EQ(write(ends[1], stream.data(), stream.size()), static_cast<ssize_t>(stream.size()));
  close(ends[1]);
  ASSERT_OK(camera_.open(ends[0]));
  ASSERT_OK(capture());
  ASSERT_OK(capture());
  EXPECT_EQ(image_->view().at(3, 3), 'b');
  EXPECT_STATUS(capture(), end_of_stream);
  close(ends[0]);
}

class LiveStream : public testing::Test {
 protected:
  LiveStream() { EXPECT_EQ(pipe(ends_), 0); }
  ~LiveStream() override {
    close(ends_[0]);
    hang_up();
  }
  void send(const std::string& bytes) {
    ASSERT_EQ(write(ends_[1], bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }
  void hang_up() {
    if (ends_[1] >= 0) close(ends_[1]);
    ends_[1] = -1;
  }
  Status capture(TimeNs now) { return camera_.capture(now, *image_, frame_); }

  int ends_[2] = {-1, -1};
  Y4mCamera camera_;
  std::unique_ptr<FrameImage> image_ = std::make_unique<FrameImage>();
  CameraFrame frame_;
};

TEST_F(LiveStream, WaitsForNoFrameAndGoesOnWithHalfOfOne) {
  send("YUV4MPEG2 W4 H4 F2:1 C420\n");
  ASSERT_OK(camera_.open(ends_[0], {.live = true}));
  EXPECT_TRUE(camera_.restarts_counter());
  EXPECT_STATUS(capture(100 * ns_per_s), not_ready) << "nothing has arrived";
  const std::string frame = "FRAME\n" + std::string(16, 'a') + std::string(8, 'c');
  // The frame arrives byte by byte. It began to arrive with its line, at 101 s.
  for (std::size_t i = 0; i < frame.size(); ++i) {
    send(frame.substr(i, 1));
    const Status status = capture(101 * ns_per_s + static_cast<TimeNs>(i) * ns_per_ms);
    if (i + 1 < frame.size()) {
      ASSERT_EQ(status.code, StatusCode::not_ready) << "after byte " << i;
    } else {
      ASSERT_OK(status);
    }
  }
  EXPECT_EQ(frame_.time_ns, 101 * ns_per_s + 5 * ns_per_ms) << "when the frame's line was complete";
  EXPECT_EQ(image_->view().at(3, 3), 'a');
  send("FRAME\n" + std::string(16, 'b') + std::string(8, 'c'));
  EXPECT_STATUS(capture(101 * ns_per_s + 504 * ns_per_ms), not_ready) << "half a second after the first";
  ASSERT_OK(capture(101 * ns_per_s + 505 * ns_per_ms));
  EXPECT_EQ(frame_.time_ns, 101 * ns_per_s + 505 * ns_per_ms);
  EXPECT_EQ(image_->view().at(0, 0), 'b');
  hang_up();
  EXPECT_STATUS(capture(110 * ns_per_s), end_of_stream);
}

TEST_F(LiveStream, AnEncoderThatStopsInAFrameEndsTheStream) {
  send("YUV4MPEG2 W4 H4 F2:1 C420\nFRAME\n" + std::string(9, 'a'));
  ASSERT_OK(camera_.open(ends_[0], {.live = true}));
  EXPECT_STATUS(capture(0), not_ready);
  hang_up();
  EXPECT_STATUS(capture(0), truncated);
  EXPECT_STATUS(capture(0), end_of_stream);
}

}  // namespace
}  // namespace ilp
