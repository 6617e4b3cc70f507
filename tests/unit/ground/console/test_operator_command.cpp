// What an operator types, against the octets that docs/commanding.md and the interface document show.
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "cfg/mission.hpp"
#include "fsw/packets/service_parameters.hpp"
#include "sim/ground/console/operator_command.hpp"
#include "sim/ground/console/telecommand_data.hpp"
#include "sim/ground/console/utc_text.hpp"
#include "tests/support/said.hpp"

namespace ilp::console {
namespace {

const Tailoring tailoring = tailoring_of(GroundSystem::standard, false, 0);
// 2026-01-01T00:00:00Z: 24837 days after 1958-01-01.
constexpr UtcNs new_year = 24837 * seconds_per_day * ns_per_s;

OperatorCommand parse(const std::string& line) {
  return parse_operator_command(line, tailoring, new_year);
}

std::string hex(const OperatorCommand& command) {
  std::string text = std::to_string(command.service) + "," + std::to_string(command.subtype) + " ";
  for (const std::uint8_t octet : command.data) {
    for (const int digit : {octet >> 4, octet & 15}) text += "0123456789abcdef"[digit];
  }
  return text;
}

/// Empty for a line that is taken.
std::string refusal(const std::string& line) {
  return test::error_of([&] { (void)parse(line); });
}

TEST(OperatorCommands, AreTheOctetsOfTheInterfaceDocument) {
  EXPECT_EQ(hex(parse("ping")), "17,1 ");
  EXPECT_EQ(hex(parse("capture")), "8,1 4341505455524500");
  EXPECT_EQ(hex(parse("capture 2026-01-01T00:01:00Z")),
            "8,1 434150544154000040610500"
            "00ea60");
  EXPECT_EQ(hex(parse("capture +60")), hex(parse("capture 2026-01-01T00:01:00")));
  EXPECT_EQ(hex(parse("series 2026-01-01T00:01:00Z 0.5 20")),
            "8,1 4341505453455200406105"
            "0000ea60"
            "000001f4"
            "0014");
  EXPECT_EQ(hex(parse("get acquisition.capture_mode")), "20,1 00010001");
  EXPECT_EQ(hex(parse("set acquisition.capture_mode 1")), "20,3 0001000101");
  EXPECT_EQ(hex(parse("mode telecommand")),
            "8,1 4341504d4f444500"
            "02");
  EXPECT_EQ(hex(parse("downlink 300")),
            "8,1 5041535342454700"
            "0000012c");
  EXPECT_EQ(hex(parse("downlink end")), "8,1 50415353454e4400");
  EXPECT_EQ(hex(parse("hold all")),
            "8,1 5846455253555350"
            "00000000");
  EXPECT_EQ(hex(parse("resume 7")),
            "8,1 5846455252455355"
            "00000007");
  EXPECT_EQ(hex(parse("cancel 7")),
            "8,1 5846455243414e43"
            "00000007");
  EXPECT_EQ(hex(parse("refine 12")),
            "8,1 524546494e450000"
            "0000000c");
  EXPECT_EQ(hex(parse("delete 12 image")),
            "8,1 50524f4444454c00"
            "0000000c"
            "01");
  EXPECT_EQ(hex(parse("strip begin")), "8,1 5354524950424547");
  EXPECT_EQ(hex(parse("strip end")), "8,1 5354524950454e44");
  EXPECT_EQ(hex(parse("flush")), "8,1 464c555348000000");
  EXPECT_EQ(hex(parse("safe on")),
            "8,1 534146454d4f4445"
            "01");
  EXPECT_EQ(hex(parse("restart telecommander")),
            "8,1 5245535441525400"
            "01");
  EXPECT_EQ(hex(parse("activate 3")),
            "8,1 4143544956415445"
            "00000003");
  EXPECT_EQ(hex(parse("schedule")), "11,17 ");
}

TEST(OperatorCommands, AnyFunctionIsCalledByItsNameWithTheArgumentsOfItsRow) {
  EXPECT_EQ(hex(parse("call FLUSH")), hex(parse("flush")));
  EXPECT_EQ(hex(parse("call CAPTAT +60")), hex(parse("capture +60")));
  EXPECT_EQ(hex(parse("call CAPTSER +60 500 20")), hex(parse("series +60 0.5 20")));
  EXPECT_EQ(hex(parse("call PRODDEL 12 1")), hex(parse("delete 12 image")));
  EXPECT_EQ(hex(parse("call CAPTPLAC 137.4 -4.5 25 3600")),
            "8,1 43415054504c4143"
            "40612ccccccccccdc012000000000000403900000000000000000e10");
  EXPECT_NE(refusal("call CAPTPLAC nan 0 25 0").find("an f64"), std::string::npos);
  EXPECT_NE(refusal("call CAPTPLAC 137.4 -4.5 25"), "");
  EXPECT_NE(refusal("call LAUNCH").find("CAPTURE"), std::string::npos);
  EXPECT_EQ(refusal("call PRODDEL 12"), "it is written: call PRODDEL u32 keyframe, u8 kind (0 depth, 1 image)");
  EXPECT_EQ(refusal("call FLUSH 1"), "it is written: call FLUSH ");
  EXPECT_NE(refusal("call PRODDEL 12 256").find("from 0 to 255"), std::string::npos);
}

TEST(OperatorCommands, ParametersGoInTheirOwnType) {
  const OperatorCommand command = parse("set overlap.target_overlap 0.75");
  ByteReader in(command.data);
  EXPECT_EQ(in.u16(), 1);
  EXPECT_EQ(in.u16(), parameter_info(find_parameter("overlap", "target_overlap")).number);
  EXPECT_EQ(in.f64(), 0.75);
  EXPECT_EQ(in.left(), 0U);
  const OperatorCommand angle = parse("set overlap.max_rotation_rad 90deg");
  ByteReader turned(angle.data);
  (void)turned.u32();
  EXPECT_NEAR(turned.f64(), 1.5707963267948966, 1e-15);
}

TEST(OperatorCommands, WhatTheFlightWouldRefuseIsRefusedHereWithTheReason) {
  const auto says = [](const std::string& line, const char* part) {
    EXPECT_NE(refusal(line).find(part), std::string::npos) << line << ": " << refusal(line);
  };
  says("launch", "there is no command launch");
  says("set overlap.target_overlap 3", "overlap.target_overlap = 3: not a number from 0.5 to 0.98");
  says("set overlap.max_rotation_rad 90", "= 90: not a number from 0 to 3.1416 rad, or degrees, written 20deg");
  says("set stereo.matcher semi_globl",
       "= semi_globl: expected semi_global or ordered_scanline; did you mean semi_global?");
  says("set overlap.target_overlap 40deg", "from 0.5 to 0.98");
  says("set overlap.none 3", "no parameter overlap.none");
  says("set target_overlap 3", "section.key");
  says("refine", "it is written: refine KEYFRAME");
  says("refine 1 2", "it is written: refine KEYFRAME");
  says("refine -1", "the keyframe must be a number");
  says("refine 1x", "the keyframe must be a number");
  says("refine 99999999999", "the keyframe must be a number");
  says("capture soon", "a time is +SECONDS or");
  says("capture 2026-02-30T00:00:00Z", "a time is +SECONDS or");
  says("strip middle", "begin or end is expected");
  says("restart engine", "structure_and_motion");
  says("show nothing", "storage");
  says("series +1 0.5 70000", "the number of images");
  says("hold some", "or the word all");
}

TEST(OperatorCommands, UnknownWordsAreNamedWithTheNearestRightOne) {
  const auto says = [](const std::string& line, const char* part) {
    EXPECT_NE(refusal(line).find(part), std::string::npos) << line << ": " << refusal(line);
  };
  says("pings", "did you mean ping?");
  says("set overlap.target_overlop 0.8", "did you mean overlap.target_overlap?");
  says("set target_overlop 0.8", "did you mean overlap.target_overlap?");
  says("set acquisition.capture_mode regulr",
       "= regulr: expected regular or forecast or telecommanded; did you mean regular?");
  says("mode forcast", "not forcast; did you mean forecast?");
  says("strip bgin", "did you mean begin?");
  says("restart downlnk", "not downlnk; did you mean downlink?");
  says("show storag", "did you mean storage?");
  says("call CAPTUR", "did you mean CAPTURE?");
}

TEST(OperatorCommands, WhatIsNotOnBoardIsNamedWithWhatToDo) {
  for (const auto& [line, part] :
       {std::pair("cancel 7", "has the number 7. To do: take the number from the line `queue`"),
        std::pair("hold all", "no file is on its way to the ground"),
        std::pair("refine 12", "of keyframe 12 is on board. To do: `show product`"),
        std::pair("delete 12 depth", "of keyframe 12 is on board"),
        std::pair("activate 3", "number 3 is on board. To do: send it by `uplink FILE.ini`")}) {
    EXPECT_NE(missing_words(parse(line)).find(part), std::string::npos) << line << ": " << missing_words(parse(line));
  }
  EXPECT_EQ(missing_words(parse("ping")), "");
  EXPECT_EQ(missing_words(parse("flush")), "");
}

TEST(OperatorCommands, EmptyLinesAndCommentsAreNothing) {
  for (const char* line : {"", "   ", "# ping"}) EXPECT_EQ(parse(line).kind, OperatorCommand::Kind::nothing);
}

TEST(OperatorCommands, WhatIsNotForTheFlightIsNoTelecommand) {
  EXPECT_EQ(parse("help").kind, OperatorCommand::Kind::help);
  EXPECT_EQ(parse("quit").kind, OperatorCommand::Kind::quit);
  EXPECT_EQ(parse("passes").kind, OperatorCommand::Kind::passes);
  EXPECT_EQ(parse("show storage").report, "storage");
  EXPECT_EQ(parse("wait 2.5").seconds, 2.5);
}

TEST(Instants, ComeBackAsTheyWereWritten) {
  EXPECT_EQ(utc_text(new_year), "2026-01-01T00:00:00.000Z");
  const auto leap_day = parse_instant("2028-02-29T23:59:59.5Z", 0);
  ASSERT_TRUE(leap_day);
  EXPECT_EQ(utc_text(*leap_day), "2028-02-29T23:59:59.500Z");
  EXPECT_EQ(parse_instant("+1.5", new_year), new_year + 1'500'000'000);
  for (const char* bad :
       {"+", "+-1", "-5", "2026-01-01", "2026-01-01T24:00:00Z", "2026-13-01T00:00:00Z", "+1e99", "+1s"}) {
    EXPECT_FALSE(parse_instant(bad, new_year)) << bad;
  }
}

}  // namespace
}  // namespace ilp::console
