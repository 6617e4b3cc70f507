// The Telecommander against telecommands of independent implementations, against other tailorings, and against noise.
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "tests/support/golden_vectors.hpp"
#include "tests/unit/commanding/telecommand_fixture.hpp"

namespace ilp::test {
namespace {

class TelecommandVectorTest : public TelecommandTest {
 protected:
  /// "1.2 packet_crc", or the types of what came.
  std::string answer_to(const Bytes& octets) {
    link.up.push_back(octets);
    clock.set(clock.now() + minor_frame_ns);
    step();
    const std::vector<Bytes> kept = link.down;
    if (std::string text = failure(); !text.empty()) return text;
    link.down = kept;
    return types();
  }
};

TEST_F(TelecommandVectorTest, EveryTelecommandOfAnIndependentImplementationIsAnswered) {
  const auto vectors = golden_vectors("tc.hex");
  if (vectors.empty()) GTEST_SKIP() << "no ../shared/data/tctm/tc.hex";
  // Parameters have types of their own here, and nothing is in the schedule yet.
  const std::map<std::string, std::string> expected = {
      {"tc_17_1", "1.1 1.3 17.2 1.7"},
      {"tc_17_1_noack", "17.2"},
      {"tc_17_1_accept", "1.1 17.2"},
      {"tc_17_1_complete", "17.2 1.7"},
      {"tc_17_1_seq16383", "1.1 1.3 17.2 1.7"},
      {"tc_17_3", "1.1 1.3 17.4 1.7"},
      {"tc_20_1", "1.1 1.3 20.2 1.7"},
      {"tc_20_1_one", "1.1 1.3 20.2 1.7"},
      {"tc_8_1", "1.1 1.3"},
      {"tc_8_1_arg", "1.1 1.3"},
      {"tc_11_1", "1.1 1.3 1.7"},
      {"tc_11_2", "1.1 1.3 1.7"},
      {"tc_11_3", "1.1 1.3 1.7"},
      {"tc_11_4", "1.1 1.3 1.7"},
      {"tc_11_4_two", "1.1 1.3 1.7"},
      {"tc_11_5", "1.4 schedule_unknown"},
      {"tc_11_7", "1.4 schedule_unknown"},
      {"tc_11_12", "1.4 schedule_unknown"},
      {"tc_11_15", "1.1 1.3 1.7"},
      {"tc_11_16", "1.1 1.3 11.10 1.7"},
      {"tc_11_17", "1.1 1.3 11.13 1.7"},
      {"tc_11_4_sub8", "1.2 request_malformed"},
      {"tc_3_5", "1.1 1.3 1.7"},
      {"tc_5_7", "1.1 1.3"},
  };
  for (const auto& [name, octets] : vectors) {
    begin();
    link.down.clear();
    const std::string answer = answer_to(octets);
    const auto known = expected.find(name);
    EXPECT_FALSE(answer.empty() && name != "tc_17_1_noack") << name;
    if (known != expected.end()) {
      EXPECT_EQ(answer, known->second) << name;
    }
    // Forget what it left: the next one meets an empty schedule.
    send(11, 3, {}, 1, 0);
    send(11, 1, {}, 1, 0);
    step();
  }
}

TEST_F(TelecommandVectorTest, ScheduleOfAnIndependentImplementationIsCarriedOutAndReportedOctetByOctet) {
  const auto up = golden_vectors("tc.hex");
  const auto down = golden_vectors("tm.hex");
  if (up.empty() || down.empty()) GTEST_SKIP() << "no ../shared/data/tctm";
  EXPECT_EQ(answer_to(up.at("tc_11_4")), "1.1 1.3 1.7");
  EXPECT_EQ(answer_to(up.at("tc_11_16")), "1.1 1.3 11.10 1.7");
  const Bytes& detail = down.at("tm_11_10");
  EXPECT_EQ(last_report[2].data, Bytes(detail.begin() + 20, detail.end() - 2));
  EXPECT_EQ(answer_to(up.at("tc_11_3")), "1.1 1.3 1.7");
  EXPECT_EQ(answer_to(up.at("tc_11_1")), "1.1 1.3 1.7");
  EXPECT_EQ(answer_to(up.at("tc_11_4_two")), "1.1 1.3 1.7");
  EXPECT_EQ(answer_to(up.at("tc_11_17")), "1.1 1.3 11.13 1.7");
  const Bytes& summary = down.at("tm_11_13");
  EXPECT_EQ(last_report[2].data, Bytes(summary.begin() + 20, summary.end() - 2));
  EXPECT_EQ(answer_to(up.at("tc_11_7")), "1.1 1.3 1.7");
  EXPECT_EQ(answer_to(up.at("tc_11_5")), "1.1 1.3 1.7");
  EXPECT_EQ(number_of<ScheduledRecord>(), 1);
}

TEST_F(TelecommandVectorTest, BadTelecommandsAreAnsweredAndNotCarriedOut) {
  const auto vectors = golden_vectors("bad_tc.hex");
  if (vectors.empty()) GTEST_SKIP() << "no ../shared/data/tctm/bad_tc.hex";
  clock.set(100 * ns_per_s);
  const std::map<std::string, std::string> expected = {
      {"bad_crc", "1.2 packet_crc"},
      {"bad_bit", "1.2 packet_crc"},
      {"bad_pus_a", "1.2 packet_pus_version"},
      {"bad_no_sec_hdr", "1.2 packet_no_secondary_header"},
      {"bad_seq_flags", "1.2 packet_segmented"},
      {"bad_type_tm", ""},
      {"bad_service", "1.2 service_unknown"},
      {"bad_subtype", "1.2 subtype_unknown"},
      {"bad_20_1_short", "1.2 request_malformed"},
      {"bad_20_1_unknown", "1.4 parameter_unknown"},
      {"bad_20_3_extra", "1.2 request_malformed"},
      {"bad_11_4_cut", "1.2 request_malformed"},
      {"bad_11_4_inner_crc", "1.4 packet_crc"},
      {"bad_11_4_past", "1.4 release_in_past"},
  };
  for (const auto& [name, octets] : vectors) {
    const std::string answer = answer_to(octets);
    EXPECT_EQ(answer.find("17.2"), std::string::npos) << name;
    if (expected.count(name) != 0) {
      EXPECT_EQ(answer, expected.at(name)) << name;
    }
    EXPECT_EQ(answer_to(packet(17, 1)), "1.1 1.3 17.2 1.7") << "after " << name;
  }
  EXPECT_EQ(number_of<ScheduledRecord>(), 0);
}

TEST_F(TelecommandVectorTest, TheFsfwTailoringFitsItsClient) {
  const auto vectors = golden_vectors("tc_fsfw.hex");
  if (vectors.empty()) GTEST_SKIP() << "no ../shared/data/tctm/tc_fsfw.hex";
  mission.tailoring = GroundSystem::fsfw;
  begin();
  EXPECT_EQ(answer_to(vectors.at("fsfw_17_1")), "1.1 1.3 17.2 1.7");
  EXPECT_EQ(answer_to(vectors.at("fsfw_11_4")), "1.1 1.3 1.7");
  EXPECT_EQ(number_of<ScheduledRecord>(), 1);
  // The clients name a scheduled request by four numbers, the first of them 0.
  EXPECT_EQ(answer_to(packet(11, 5, numbers({{0, 2}, {0, 2}, {apid, 2}, {203, 2}}))), "1.1 1.3 1.7");
  EXPECT_EQ(number_of<ScheduledRecord>(), 0);
}

TEST_F(TelecommandVectorTest, TheYamcsTailoringHasItsOwnWidths) {
  mission.tailoring = GroundSystem::yamcs;
  begin();
  // Sub-schedule 1, one request; CUC of 2026-01-01T00:00:05 with 5 leap seconds since 2000.
  const Bytes release = from_hex("2f30e8758a000000");
  EXPECT_TRUE(writer->settings().time.mission(24837 * seconds_per_day * ns_per_s) == 0);
  link.up.push_back(packet(11, 4, from_hex("0101") + release + packet(17, 1)));
  step();
  ASSERT_EQ(link.down.size(), 3U);
  Telemetry report;
  ASSERT_TRUE(decode_telemetry(link.down[2], apid, tailorings()[2].time, report).ok());
  EXPECT_EQ(report.service, 1);
  EXPECT_EQ(report.subtype, 7);
  const auto scheduled = read<ScheduledRecord>(1);
  EXPECT_EQ(scheduled.release_ns, 5 * ns_per_s);
  EXPECT_EQ(scheduled.sub_schedule, 1U);
  link.down.clear();
  link.up.push_back(packet(77, 1));
  step();
  ASSERT_EQ(link.down.size(), 1U);
  ASSERT_TRUE(decode_telemetry(link.down[0], apid, tailorings()[2].time, report).ok());
  ByteReader in(report.data);
  static_cast<void>(in.u32());
  EXPECT_EQ(in.u32(), static_cast<std::uint32_t>(StatusCode::service_unknown));
}

/// Packets of every service with octets changed, cut and appended, whose CRC is right or not, in one long session.
TEST_F(TelecommandVectorTest, NoiseIsAnsweredAndSurvived) {
  mission.link_bytes_per_s = 1e9;
  std::mt19937 random(20261122);
  const auto number = [&random](std::uint32_t below) { return static_cast<std::uint32_t>(random() % below); };
  const std::vector<std::pair<int, int>> types_of = {{8, 1},   {11, 1}, {11, 2},  {11, 4},  {11, 5},
                                                     {11, 7},  {11, 9}, {11, 12}, {11, 15}, {11, 16},
                                                     {11, 17}, {17, 1}, {17, 3},  {20, 1},  {20, 3}};
  const char* const names[] = {"CAPTURE", "CAPTAT", "CAPTSER", "CAPMODE", "FLUSH", "REFINE", "PRODDEL", "RESTART"};
  std::set<StatusCode> reasons;
  std::set<std::pair<int, int>> reports;
  for (int i = 0; i < 20000; ++i) {
    const auto [service, subtype] = types_of[number(static_cast<std::uint32_t>(types_of.size()))];
    const Bytes time = time_of(clock.now() + (static_cast<TimeNs>(number(4000)) - 300) * ns_per_ms);
    const Bytes name = numbers({{1, 2}, {apid, 2}, {count - number(40), 2}});
    const Bytes one = numbers({{1, 2}});
    Bytes data;
    if (service == 8) data = function(names[number(8)]) + (number(2) == 0 ? time : Bytes{});
    if (service == 11 && subtype == 4) data = one + time + packet(17, 1);
    if (service == 11 && (subtype == 5 || subtype == 9 || subtype == 12)) data = one + name;
    if (service == 11 && subtype == 7) data = numbers({{number(3000), 4}}) + one + name;
    if (service == 11 && subtype == 15) data = numbers({{number(3000), 4}});
    if (service == 17 && subtype == 3) data = {0, 0xEF};
    if (service == 20) data = one + numbers({{1 + number(100), 2}});
    if (number(2) == 0) {
      for (std::uint32_t n = number(9); n > 0; --n) data.push_back(static_cast<std::uint8_t>(number(256)));
    }
    Bytes octets = packet(service, subtype, data);
    if (number(8) == 0)
      octets[number(static_cast<std::uint32_t>(octets.size()))] ^= static_cast<std::uint8_t>(number(256));
    if (number(16) == 0) octets.resize(number(static_cast<std::uint32_t>(octets.size()) + 1));
    link.up.push_back(octets);
    if (i % 8 != 7) continue;
    clock.set(clock.now() + minor_frame_ns);
    const StepResult result = telecommander->step();
    ASSERT_TRUE(result.status.ok()) << i << " " << status_name(result.status.code);
    for (const Report& report : received()) {
      reports.insert({report.service, report.subtype});
      if (report.service == 1 && report.subtype % 2 == 0) reasons.insert(code_of(report));
    }
    if (i % 512 == 511) begin();
  }
  for (const StatusCode code : {StatusCode::packet_crc, StatusCode::request_malformed, StatusCode::function_arguments,
                                StatusCode::schedule_unknown, StatusCode::release_in_past}) {
    EXPECT_EQ(reasons.count(code), 1U) << status_name(code);
  }
  EXPECT_GT(reasons.size(), 15U);
  EXPECT_EQ(reports.size(), 11U) << "1.1 to 1.4, 1.7, 1.8, 11.10, 11.13, 17.2, 17.4, 20.2";
  EXPECT_EQ(reasons.count(StatusCode::assertion_failed), 0U);
  EXPECT_EQ(reasons.count(StatusCode::store_error), 0U);
}

}  // namespace
}  // namespace ilp::test
