// The check of a camera on the bench, where there is none.
#include <gtest/gtest.h>

#include "tests/integration/flight_files.hpp"

namespace ilp {
namespace {

TEST(CameraCheck, OfADeviceThatIsNotThereEndsAtOnceAndSaysWhatToDo) {
  // A check that waited would take longer than the test may.
  const test::ProgramResult result =
      test::run_program({ILP_CAMERA_CHECK, "/dev/video-not-there,rate=10", "640", "480", "100000"});
  EXPECT_EQ(result.exit_status, 1) << result.output;
  EXPECT_NE(result.output.find("/dev/video-not-there cannot be opened: No such file"), std::string::npos)
      << result.output;
  EXPECT_NE(result.output.find("v4l2-ctl --list-devices"), std::string::npos) << result.output;
}

TEST(CameraCheck, SaysHowItIsCalled) {
  const test::ProgramResult help = test::run_program({ILP_CAMERA_CHECK, "--help"});
  EXPECT_EQ(help.exit_status, 0);
  EXPECT_NE(help.output.find("Example: ilp-camera-check /dev/video0"), std::string::npos) << help.output;
  EXPECT_EQ(test::run_program({ILP_CAMERA_CHECK, "/dev/video0"}).exit_status, 2);
}

}  // namespace
}  // namespace ilp
