// The flight binary takes its images from the pipe of a real encoder: ffmpeg.
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "sim/host/colmap.hpp"
#include "tests/integration/flight_files.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

const fs::path plain = test::prepared_flights() / "plain";

class VideoEncoder : public testing::Test {
 protected:
  void SetUp() override {
    if (test::run_program({"/bin/sh", "-c", "command -v ffmpeg"}).exit_status != 0) {
      GTEST_SKIP() << "ffmpeg is not installed (bsp/install-packages long)";
    }
    for (const char* name : {"outbox", "acknowledged"}) fs::create_directories(folder_ / name);
  }
  /// `ffmpeg` with its options before the images, piped into the flight.
  [[nodiscard]] test::ProgramResult fly(const std::string& encoder, const std::string& wrapper,
                                        const std::string& more) const {
    const CameraModel c = host::read_colmap_camera(plain / "cameras.txt");
    std::ostringstream line;
    line.precision(17);
    line << encoder << " -i '" << (plain / "images" / "%04d.pgm").string()
         << "' -pix_fmt gray -strict -1 -f yuv4mpegpipe - | " << wrapper << " " << ILP_ONBOARD << " " << more
         << " --y4m - --camera '" << c.width << " " << c.height << " " << c.fx << " " << c.fy << " " << c.cx << " "
         << c.cy << "' --database '" << (folder_ / "flight.db") << "' --outbox '" << (folder_ / "outbox")
         << "' --acknowledgements '" << (folder_ / "acknowledged") << "'";
    return test::run_program({"/bin/sh", "-c", line.str()});
  }
  test::TemporaryFolder folder_;
};

TEST_F(VideoEncoder, ItsFramesMakeThePosesOfTheImagesThatItWasGiven) {
  const test::ProgramResult flown = fly("ffmpeg -loglevel error -framerate 1/4", "", "--virtual-time");
  ASSERT_EQ(flown.exit_status, 0) << flown.output;
  const auto expected = test::records_of<PoseRecord>(test::prepared_flights() / "uninterrupted");
  const auto poses = test::records_of<PoseRecord>(fs::path(folder_ / ""));
  ASSERT_EQ(poses.size(), expected.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(poses[i].state, expected[i].state) << "keyframe " << poses[i].id;
    EXPECT_TRUE(std::equal(poses[i].centre, poses[i].centre + 3, expected[i].centre)) << "keyframe " << poses[i].id;
  }
}

TEST_F(VideoEncoder, InRealTimeEveryFrameIsTakenAtTheStreamsRate) {
  // 20 images last 5 s; the flight is ended in order afterwards.
  const test::ProgramResult flown = fly("ffmpeg -loglevel error -re -framerate 4", "timeout --signal=TERM 12", "");
  ASSERT_NE(flown.output.find("heap requests after sealing: 0\n"), std::string::npos) << flown.output;
  const std::vector<FrameRecord> taken = test::records_of<FrameRecord>(fs::path(folder_ / ""));
  ASSERT_EQ(taken.size(), 20U) << flown.output;
  EXPECT_GE(taken[0].time_ns, 0);
  for (std::size_t i = 1; i < taken.size(); ++i) {
    EXPECT_EQ(taken[i].time_ns - taken[i - 1].time_ns, 250 * ns_per_ms) << "frame " << i;
    EXPECT_EQ(taken[i].sequence, taken[i - 1].sequence + 1);
  }
}

}  // namespace
}  // namespace ilp
