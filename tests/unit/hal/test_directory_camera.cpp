// Recorded strips: the index, the images, and everything that can be wrong with either.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <memory>
#include <string>

#include "hal/camera/directory/directory_camera.hpp"
#include "hal/camera/directory/pgm.hpp"
#include "tests/unit/hal/expect_status.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {

constexpr TimeNs late = 1'000'000'000'000;

class DirectoryCameraTest : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& content) {
    std::ofstream(folder_ / name, std::ios::binary) << content;
  }
  /// A `width` x `height` image whose grey values count up from `first`.
  static std::string pgm(int width, int height, int first) {
    std::string text = "P5\n" + std::to_string(width) + " " + std::to_string(height) + "\n255\n";
    for (int i = 0; i < width * height; ++i) text += static_cast<char>(first + i);
    return text;
  }
  Status open(const std::string& index, int width = 0, int height = 0, DecodeImage decode = nullptr) {
    write("index.txt", index);
    return camera_.open((folder_ / "index.txt").c_str(), width, height, decode);
  }
  Status capture(TimeNs now = late) { return camera_.capture(now, *image_, frame_); }
  Status decode_pgm(const std::string& content) {
    write("image.pgm", content);
    return read_pgm((folder_ / "image.pgm").c_str(), *image_);
  }

  test::TemporaryFolder folder_;
  DirectoryCamera camera_;
  std::unique_ptr<FrameImage> image_ = std::make_unique<FrameImage>();
  CameraFrame frame_;
};

TEST_F(DirectoryCameraTest, TheSizeIsThatOfTheFirstImageWithOne) {
  std::int32_t width = 0, height = 0;
  write("index.txt", "# a strip\nnonsense\n1000 none.pgm\n2000 bad.pgm\n3000 a.pgm 12.5\n4000 b.pgm\n");
  write("bad.pgm", "P6\n9 9\n255\n");
  const std::string index = folder_ / "index.txt";
  EXPECT_STATUS(camera_.find_size(index.c_str(), width, height), not_found);
  write("a.pgm", pgm(4, 3, 10));
  write("b.pgm", pgm(8, 6, 10));
  ASSERT_OK(camera_.find_size(index.c_str(), width, height));
  EXPECT_EQ(width, 4);
  EXPECT_EQ(height, 3);
  EXPECT_STATUS(camera_.find_size((folder_ / "none.txt").c_str(), width, height), not_found);
  EXPECT_STATUS(capture(), end_of_stream) << "it is closed";
}

TEST_F(DirectoryCameraTest, DeliversFramesWhenTheyAreDue) {
  write("a.pgm", pgm(4, 3, 10));
  write("b.pgm", pgm(4, 3, 50));
  ASSERT_OK(open("# a strip\n\n  1000 a.pgm 12.5\r\n2000\tb.pgm # no altitude\n"));
  EXPECT_STATUS(capture(999), not_ready);
  EXPECT_EQ(camera_.next_due(), 1000);
  ASSERT_OK(capture(1000));
  EXPECT_EQ(frame_.time_ns, 1000);
  EXPECT_EQ(frame_.sequence, 1);
  EXPECT_EQ(frame_.altitude, 12.5);
  EXPECT_STREQ(frame_.name, "a.pgm");
  ASSERT_EQ(image_->width(), 4);
  ASSERT_EQ(image_->height(), 3);
  EXPECT_EQ(image_->view().at(0, 0), 10);
  EXPECT_EQ(image_->view().at(3, 2), 21);
  EXPECT_STATUS(capture(1999), not_ready);
  ASSERT_OK(capture(5000));
  EXPECT_EQ(frame_.time_ns, 2000);
  EXPECT_TRUE(std::isnan(frame_.altitude));
  EXPECT_EQ(image_->view().at(0, 0), 50);
  const Status end = capture();
  EXPECT_EQ(end.code, StatusCode::end_of_stream);
  EXPECT_EQ(end.a, 2);
  EXPECT_STATUS(capture(), end_of_stream);
}

TEST_F(DirectoryCameraTest, LostFramesAreNamedAndTheStripGoesOn) {
  write("good.pgm", pgm(4, 3, 0));
  write("short.pgm", pgm(4, 3, 0).substr(0, 20));
  write("other.pgm", pgm(5, 3, 0));
  write("colour.pgm", "P6\n1 1\n255\nabc");
  write("wide.pgm", "P5 " + std::to_string(limits::max_sensor_side + 1) + " 1 255\n" + std::string(5000, 'x'));
  ASSERT_OK(open("1 short.pgm\n2 missing.pgm\n3 other.pgm\n4 colour.pgm\n5 wide.pgm\n6 good.pgm\n", 4, 3));
  EXPECT_STATUS(capture(), truncated);
  EXPECT_STREQ(frame_.name, "short.pgm");
  EXPECT_STATUS(capture(), not_found);
  EXPECT_STREQ(frame_.name, "missing.pgm");
  const Status size = capture();
  EXPECT_EQ(size.code, StatusCode::image_size_changed);
  EXPECT_EQ(size.a, 5);
  EXPECT_EQ(size.b, 3);
  EXPECT_STATUS(capture(), unsupported_format);
  EXPECT_STATUS(capture(), image_too_large);
  ASSERT_OK(capture());
  EXPECT_EQ(frame_.sequence, 6);
  EXPECT_STATUS(capture(), end_of_stream);
}

TEST_F(DirectoryCameraTest, LargePicturesAreReducedAndStillHaveOneSize) {
  const int width = 2 * limits::max_image_width, height = 130;
  std::string large = "P5\n" + std::to_string(width) + " " + std::to_string(height) + "\n255\n";
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) large += static_cast<char>(x / 16 + y / 2);
  }
  write("large.pgm", large);
  write("short.pgm", large.substr(0, large.size() - 1));
  // Its image would have the same size, with another scale.
  write("half.pgm", pgm(width / 2, height / 2, 0));
  ASSERT_OK(open("1 large.pgm\n2 half.pgm\n3 short.pgm\n", width, height));
  ASSERT_OK(capture());
  ASSERT_EQ(image_->width(), width / 2);
  ASSERT_EQ(image_->height(), height / 2);
  for (std::int32_t y = 0; y < height / 2; ++y) {
    for (std::int32_t x = 0; x < width / 2; ++x) ASSERT_EQ(image_->view().at(x, y), (x / 8 + y) % 256);
  }
  EXPECT_STATUS(capture(), image_size_changed);
  EXPECT_STATUS(capture(), truncated);
}

TEST_F(DirectoryCameraTest, LinesThatAreNoFrameAreReportedOneByOne) {
  write("a.pgm", pgm(1, 1, 0));
  const std::string long_name(1000, 'n');
  const std::string index =
      "x a.pgm\n1x a.pgm\n12345678901234567890 a.pgm\n1\n1 a.pgm high\n1 a.pgm 1e3\n1 a.pgm 5 6\n1 " + long_name +
      "\n" + std::string(10000, ' ') + "1 a.pgm\n--1 a.pgm\n7 a.pgm";
  ASSERT_OK(open(index));
  for (int line = 1; line <= 10; ++line) {
    const Status status = capture();
    EXPECT_EQ(status.code, StatusCode::parse_error) << "line " << line;
    EXPECT_EQ(status.a, line);
    EXPECT_EQ(frame_.sequence, line);
  }
  ASSERT_OK(capture()) << "the last line has no end";
  EXPECT_EQ(frame_.time_ns, 7);
  EXPECT_STATUS(capture(), end_of_stream);
}

TEST_F(DirectoryCameraTest, ReadsAltitudesOfAnySign) {
  write("a.pgm", pgm(1, 1, 0));
  ASSERT_OK(open("1 a.pgm -3.25\n2 a.pgm 0.1\n3 a.pgm 1500\n4 a.pgm 7.12345678901234567890\n"));
  for (const double altitude : {-3.25, 0.1, 1500.0, 7.123456789012}) {
    ASSERT_OK(capture());
    EXPECT_DOUBLE_EQ(frame_.altitude, altitude);
  }
}

TEST_F(DirectoryCameraTest, TimesThatDoNotIncreaseLoseTheFrame) {
  write("a.pgm", pgm(1, 1, 0));
  ASSERT_OK(open("-5 a.pgm\n100 a.pgm\n100 a.pgm\n40 a.pgm\n101 a.pgm\n"));
  ASSERT_OK(capture());
  EXPECT_EQ(frame_.time_ns, -5);
  ASSERT_OK(capture());
  EXPECT_STATUS(capture(), time_not_monotonic);
  const Status status = capture();
  EXPECT_EQ(status.code, StatusCode::time_not_monotonic);
  EXPECT_EQ(status.a, 4);
  EXPECT_EQ(status.b, 60);
  ASSERT_OK(capture());
  EXPECT_EQ(frame_.time_ns, 101);
}

TEST_F(DirectoryCameraTest, HostsMayDecodeOtherFormats) {
  static std::string asked;
  ASSERT_OK(open("1 sub/x.png\n2 /abs/y.png\n", 0, 0, [](const char* path, FrameImage& image) {
    asked = path;
    return image.resize(2, 2);
  }));
  ASSERT_OK(capture());
  EXPECT_EQ(asked, folder_ / "sub/x.png");
  EXPECT_STREQ(frame_.name, "x.png");
  ASSERT_OK(capture());
  EXPECT_EQ(asked, "/abs/y.png");
}

TEST_F(DirectoryCameraTest, OpensAgainAndAnswersWhenNotOpen) {
  EXPECT_STATUS(capture(), end_of_stream);
  EXPECT_STATUS(camera_.open((folder_ / "none.txt").c_str(), 0, 0, nullptr), not_found);
  EXPECT_STATUS(capture(), end_of_stream);
  EXPECT_STATUS(camera_.open((std::string(600, 'd') + "/index.txt").c_str(), 0, 0, nullptr), capacity_exceeded);
  write("a.pgm", pgm(1, 1, 0));
  for (int round = 0; round < 2; ++round) {
    ASSERT_OK(open("5 a.pgm\n"));
    ASSERT_OK(capture());
    EXPECT_EQ(frame_.sequence, 1);
    EXPECT_STATUS(capture(), end_of_stream);
  }
  EXPECT_OK(camera_.open((folder_ / "").c_str(), 0, 0, nullptr));
  EXPECT_STATUS(capture(), io_error) << "a folder is no index";
  EXPECT_STATUS(capture(), end_of_stream) << "a source that fails does not fail for ever";
}

TEST_F(DirectoryCameraTest, PgmHeadersAsTheFormatAllowsThem) {
  ASSERT_OK(decode_pgm("P5\n# made by hand\n2 # width\n\t1\r\n255\n\x0A\xFF"));
  EXPECT_EQ(image_->width(), 2);
  EXPECT_EQ(image_->height(), 1);
  EXPECT_EQ(image_->view().at(0, 0), 0x0A) << "the first pixel is no blank of the header";
  EXPECT_EQ(image_->view().at(1, 0), 0xFF);
  EXPECT_STATUS(decode_pgm("P2\n1 1\n255\n1"), unsupported_format);
  EXPECT_STATUS(decode_pgm("P5\n1 1\n65535\nab"), unsupported_format);
  EXPECT_STATUS(decode_pgm("P5\n0 1\n255\n"), parse_error);
  EXPECT_STATUS(decode_pgm("P5\n-1 1\n255\n"), parse_error);
  EXPECT_STATUS(decode_pgm("P5\n99999999999999999999 1\n255\n"), parse_error);
  EXPECT_STATUS(decode_pgm("P5\n65536 65536\n255\nab"), image_too_large);
  EXPECT_STATUS(decode_pgm("P5\n2 2\n255\nabc"), truncated);
  EXPECT_STATUS(decode_pgm("P5\n2 2\n"), truncated);
  EXPECT_STATUS(decode_pgm("P"), truncated);
  EXPECT_STATUS(decode_pgm(""), truncated);
  EXPECT_STATUS(decode_pgm("P5\n#" + std::string(100000, 'c')), parse_error);
}

TEST_F(DirectoryCameraTest, EveryBeginningOfAnImageIsAStatus) {
  const std::string whole = pgm(7, 5, 1);
  for (std::size_t size = 0; size < whole.size(); ++size) EXPECT_STATUS(decode_pgm(whole.substr(0, size)), truncated);
  EXPECT_OK(decode_pgm(whole));
}

}  // namespace
}  // namespace ilp
