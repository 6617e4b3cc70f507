// What contradicts itself in a mission is refused by name of the relation, whatever way it comes.
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "cfg/mission.hpp"
#include "cfg/mission_text.hpp"
#include "cfg/schedule.hpp"

namespace ilp {
namespace {

Status read(const std::string& text, MissionParameters& mission) {
  MissionText reader(mission);
  reader.add({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  return reader.finish(mission);
}

TEST(MissionText, AnAngleMayBeInDegreesAndAPlainNumberIsInRadians) {
  MissionParameters mission;
  ASSERT_TRUE(read("[overlap]\nmax_rotation_rad = 90deg\n[calibration]\nfield_of_view_rad = 6e1deg", mission).ok());
  EXPECT_NEAR(mission.max_rotation_rad, 1.5707963267948966, 1e-15);
  EXPECT_NEAR(mission.field_of_view_rad, 1.0471975511965976, 1e-15);
  ASSERT_TRUE(read("[overlap]\nmax_rotation_rad = 0.5", mission).ok());
  EXPECT_EQ(mission.max_rotation_rad, 0.5);
  for (const char* wrong : {"90", "900deg", "deg", "90 degrees", "0x5deg", "90deg deg", "-1deg"})
    EXPECT_FALSE(read("[overlap]\nmax_rotation_rad = " + std::string(wrong), mission).ok()) << wrong;
  EXPECT_FALSE(read("[overlap]\ntarget_overlap = 40deg", mission).ok()) << "no angle";
  EXPECT_EQ(mission.max_rotation_rad, 0.5);
}

TEST(MissionRelations, AnIntervalIsZeroOrAtLeastAMinorFrame) {
  for (double MissionParameters::*interval :
       {&MissionParameters::capture_interval_s, &MissionParameters::housekeeping_period_s,
        &MissionParameters::cfdp_prompt_s, &MissionParameters::confirmation_timeout_s}) {
    MissionParameters mission;
    mission.capture_min_interval_s = 0.05;
    for (const double wrong : {1e-10, 0.0999, std::numeric_limits<double>::denorm_min()}) {
      mission.*interval = wrong;
      EXPECT_EQ(validate(mission).code, StatusCode::parameters_contradict) << wrong;
      EXPECT_EQ(validate(mission).a, 12) << wrong;
    }
    for (const double right : {0.0, 0.1, 3600.0}) {
      mission.*interval = right;
      EXPECT_TRUE(validate(mission).ok()) << right;
    }
  }
}

TEST(MissionRelations, FramesAreNotWantedFasterThanTheCameraGivesThem) {
  MissionParameters mission;
  mission.capture_min_interval_s = 2;
  mission.capture_interval_s = 1.9;
  EXPECT_EQ(validate(mission).a, 13);
  mission.capture_interval_s = 2;
  EXPECT_TRUE(validate(mission).ok());
}

TEST(MissionRelations, AFileThatContradictsItselfChangesNothing) {
  MissionParameters mission;
  const Status status = read("[acquisition]\ncapture_interval_s = 1e-10\n", mission);
  EXPECT_EQ(status.code, StatusCode::parameters_contradict);
  EXPECT_EQ(status.a, 12);
  EXPECT_EQ(mission.capture_interval_s, 0);
}

TEST(MissionValues, AreTakenByNameAndByNumber) {
  MissionParameters mission;
  ASSERT_TRUE(read("[acquisition]\ncapture_mode = forecast\n[overlap]\noverlap_sad = true\nfeature_overlap = false\n"
                   "[link]\ncfdp_checksum = crc32c\nauthentication = 2\n",
                   mission)
                  .ok());
  EXPECT_EQ(mission.capture_mode, CaptureMode::forecast);
  EXPECT_TRUE(mission.overlap_sad);
  EXPECT_FALSE(mission.feature_overlap);
  EXPECT_EQ(mission.cfdp_checksum, cfdp::ChecksumType::crc32c);
  EXPECT_EQ(mission.authentication, Authentication::telecommands_and_files);
  ASSERT_TRUE(read("[acquisition]\ncapture_mode = 0\n[overlap]\noverlap_sad = 0\n", mission).ok());
  EXPECT_EQ(mission.capture_mode, CaptureMode::regular);
  EXPECT_FALSE(mission.overlap_sad);
}

TEST(MissionValues, ThatTheirTypeDoesNotHaveAreRefused) {
  for (const char* wrong :
       {"[acquisition]\ncapture_mode = 3", "[acquisition]\ncapture_mode = 0.5",
        "[acquisition]\ncapture_mode = sometimes", "[overlap]\noverlap_sad = yes", "[link]\ncfdp_checksum = 1",
        "[motion]\ncorners = 1000.5", "[motion]\ncorners = forecast"}) {
    MissionParameters mission;
    const Status status = read(wrong, mission);
    EXPECT_EQ(status.code, StatusCode::parameter_out_of_range) << wrong;
    EXPECT_EQ(status.b, 2) << wrong;
  }
}

TEST(MissionValues, EveryParameterTakesItsDefaultItsLeastAndItsMost) {
  for (std::size_t i = 0; i < parameter_count(); ++i) {
    const ParameterInfo& info = parameter_info(i);
    MissionParameters mission;
    for (const double value : {parameter_value(mission, i), info.minimum, info.maximum}) {
      ASSERT_TRUE(set_parameter(mission, i, value).ok()) << info.key << " " << value;
      EXPECT_EQ(parameter_value(mission, i), value) << info.key;
    }
    EXPECT_FALSE(set_parameter(mission, i, info.maximum + 1).ok()) << info.key;
    EXPECT_FALSE(set_parameter(mission, i, std::numeric_limits<double>::quiet_NaN()).ok()) << info.key;
  }
}

TEST(Seconds, BecomeNanosecondsWithoutLeavingTheirRange) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(ns_from_seconds(1.5), 1'500'000'000);
  EXPECT_EQ(ns_from_seconds(-2e-9), -2);
  EXPECT_EQ(ns_from_seconds(std::numeric_limits<double>::denorm_min()), 0);
  for (const double far : {4e9, 9.3e9, 1e300, infinity}) {
    EXPECT_EQ(ns_from_seconds(far), longest_duration_ns) << far;
    EXPECT_EQ(ns_from_seconds(-far), -longest_duration_ns) << far;
  }
  EXPECT_EQ(ns_from_seconds(std::numeric_limits<double>::quiet_NaN()), 0);
  EXPECT_GE(std::numeric_limits<TimeNs>::max() - longest_duration_ns, longest_duration_ns) << "two can be added";
  // Every parameter in seconds that is a duration or a mission time fits: none is cut to the longest.
  for (std::size_t i = 0; i < parameter_count(); ++i) {
    const ParameterInfo& info = parameter_info(i);
    if (std::string(info.unit) != "s" || std::string(info.section) == "link") continue;
    EXPECT_LE(info.maximum, 1e-9 * static_cast<double>(longest_duration_ns)) << info.key;
  }
}

}  // namespace
}  // namespace ilp
