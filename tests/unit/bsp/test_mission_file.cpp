// Mission files with mistakes: each is refused with what is wrong, or is right; none takes effect in part.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "bsp/flight/mission_file.hpp"
#include "cfg/mission_text.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {

class MissionFile : public testing::Test {
 protected:
  Status read(const std::string& text) {
    const std::string path = folder_ / "mission.ini";
    std::ofstream(path, std::ios::binary) << text;
    mission_ = {};
    return read_mission_file(path.c_str(), mission_, error_);
  }
  /// The same by radio.
  static Status uplinked(const std::string& text) {
    MissionParameters mission;
    MissionText reader(mission);
    reader.add({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
    return reader.finish(mission);
  }
  const test::TemporaryFolder folder_;
  MissionParameters mission_;
  MissionEntry error_;
};

TEST_F(MissionFile, NumbersThatAreNoneAreNamed) {
  for (const char* wrong : {"nan", "-nan", "NaN(123)", "inf", "-inf", "1e999", "-1", "1e308", "", "2x", "0x", "--1"}) {
    const Status status = read(std::string("[acquisition]\ncapture_interval_s = ") + wrong + "\n");
    EXPECT_EQ(status.code, StatusCode::parameter_out_of_range) << wrong;
    EXPECT_STREQ(error_.key, "capture_interval_s") << wrong;
    EXPECT_EQ(mission_.capture_interval_s, 0) << wrong;
    EXPECT_FALSE(uplinked(std::string("[acquisition]\ncapture_interval_s = ") + wrong + "\n").ok()) << wrong;
  }
}

TEST_F(MissionFile, DenormalsContradictWhatAnIntervalIs) {
  for (const char* small : {"4.9e-324", "2.2e-308", "1e-10"}) {
    const Status status = read(std::string("[acquisition]\ncapture_interval_s = ") + small + "\n");
    EXPECT_EQ(status.code, StatusCode::parameters_contradict) << small;
    EXPECT_EQ(status.a, 12) << small;
    EXPECT_EQ(mission_.capture_interval_s, 0) << small;
    EXPECT_FALSE(uplinked(std::string("[acquisition]\ncapture_interval_s = ") + small + "\n").ok()) << small;
  }
}

TEST_F(MissionFile, AnEmptyFileChangesNothing) {
  for (const char* empty : {"", "\n\n", "# nothing\n", "[acquisition]\n"}) {
    EXPECT_TRUE(read(empty).ok()) << empty;
    EXPECT_TRUE(uplinked(empty).ok()) << empty;
  }
}

TEST_F(MissionFile, WhatIsNoTextIsRefusedWithItsLine) {
  const std::string nul("[acquisition]\ncapture_mode = 1\0 # hidden\n", 40);
  Status status = read(nul);
  EXPECT_EQ(status.code, StatusCode::parse_error);
  EXPECT_EQ(status.a, 2);
  EXPECT_EQ(mission_.capture_mode, CaptureMode::regular);
  std::string binary;
  for (int i = 0; i < 100'000; ++i) binary.push_back(static_cast<char>(i * 7 % 256));
  EXPECT_EQ(read(binary).code, StatusCode::parse_error);
  EXPECT_FALSE(uplinked(binary).ok());
}

TEST_F(MissionFile, WhatALongLineHidesIsNotRead) {
  const std::string hidden = "[acquisition]\n#" + std::string(255, ' ') + "capture_mode = 1\n";
  const Status status = read(hidden);
  EXPECT_EQ(status.code, StatusCode::parse_error);
  EXPECT_EQ(status.a, 2);
  EXPECT_EQ(mission_.capture_mode, CaptureMode::regular);
}

TEST_F(MissionFile, AHugeFileIsReadLikeAnyOther) {
  std::string huge = "[acquisition]\n";
  for (int i = 0; i < 500'000; ++i) huge += "# a comment\n";
  EXPECT_TRUE(read(huge + "capture_mode = 1\n").ok());
  EXPECT_EQ(mission_.capture_mode, CaptureMode::forecast);
  EXPECT_EQ(read(huge + "nonsense\n").code, StatusCode::parse_error);
}

TEST_F(MissionFile, AFolderIsNoMission) {
  const Status status = read_mission_file((folder_ / "").c_str(), mission_, error_);
  EXPECT_EQ(status.code, StatusCode::io_error);
  EXPECT_EQ(read_mission_file((folder_ / "none").c_str(), mission_, error_).code, StatusCode::not_found);
}

}  // namespace
}  // namespace ilp
