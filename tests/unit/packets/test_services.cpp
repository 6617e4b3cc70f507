// Bodies of the services against the octets of independent implementations, and cut at every length.
#include <gtest/gtest.h>

#include <array>
#include <cstring>

#include "fsw/packets/service_events.hpp"
#include "fsw/packets/service_functions.hpp"
#include "fsw/packets/service_housekeeping.hpp"
#include "fsw/packets/service_parameters.hpp"
#include "fsw/packets/service_schedule.hpp"
#include "fsw/packets/service_verification.hpp"
#include "tests/support/golden_vectors.hpp"

namespace ilp {
namespace {

constexpr std::uint16_t apid = 0x0EF;
constexpr UtcNs year_2026 = 24837 * seconds_per_day * ns_per_s;

const Tailoring& standard() {
  return tailorings()[0];
}
const Tailoring& fsfw() {
  return tailorings()[1];
}
const Tailoring& yamcs() {
  return tailorings()[2];
}

/// Application data of a packet: the octets after its headers and before its CRC.
Bytes telecommand_data(const Bytes& packet) {
  return {packet.begin() + 11, packet.end() - 2};
}
Bytes telemetry_data(const Bytes& packet) {
  return {packet.begin() + 20, packet.end() - 2};
}

class Written {
 public:
  ByteWriter out{octets_};
  [[nodiscard]] Bytes bytes() const {
    EXPECT_TRUE(out.ok());
    return {out.written().begin(), out.written().end()};
  }

 private:
  std::array<std::uint8_t, 1024> octets_{};
};

/// `decode` is not ok for the data cut anywhere, or with an octet after them.
template <typename Decode>
void expect_whole_only(const Bytes& data, Decode decode) {
  EXPECT_TRUE(decode(std::span<const std::uint8_t>(data)).ok());
  for (std::size_t size = 0; size < data.size(); ++size) {
    EXPECT_FALSE(decode(std::span<const std::uint8_t>(data).first(size)).ok()) << size << " of " << data.size();
  }
  Bytes longer = data;
  longer.push_back(0);
  EXPECT_FALSE(decode(std::span<const std::uint8_t>(longer)).ok());
}

class ServiceVectors : public testing::Test {
 protected:
  void SetUp() override {
    if (telecommands.empty() || telemetry.empty()) GTEST_SKIP() << "no ../shared/data/tctm";
  }
  [[nodiscard]] Bytes tc(const char* name) const { return telecommand_data(telecommands.at(name)); }
  [[nodiscard]] Bytes tm(const char* name) const { return telemetry_data(telemetry.at(name)); }

  std::map<std::string, Bytes> telecommands = golden_vectors("tc.hex");
  std::map<std::string, Bytes> telemetry = golden_vectors("tm.hex");
};

TEST_F(ServiceVectors, Verification) {
  struct Case {
    const char* name;
    std::uint8_t subtype;
    std::uint32_t step, code;
    Bytes data;
  };
  const Case cases[] = {{"tm_1_1", 1, 0, 0, {}},       {"tm_1_3", 3, 0, 0, {}},
                        {"tm_1_7", 7, 0, 0, {}},       {"tm_1_5_step1", 5, 1, 0, {}},
                        {"tm_1_5_step2", 5, 2, 0, {}}, {"tm_1_2", 2, 0, 3, {}},
                        {"tm_1_4", 4, 0, 258, {0, 1}}, {"tm_1_8", 8, 0, 65535, {0, 1, 0x86, 0xA0}},
                        {"tm_1_6", 6, 2, 7, {}},       {"tm_1_10", 10, 0, 1, {}}};
  for (const Case& c : cases) {
    const Bytes data = tm(c.name);
    VerificationReport report;
    ASSERT_TRUE(decode_verification(standard(), c.subtype, data, report).ok()) << c.name;
    EXPECT_EQ(report.request, 0x18EFC017U) << c.name;
    EXPECT_EQ(report.step, c.step) << c.name;
    EXPECT_EQ(report.code, c.code) << c.name;
    EXPECT_EQ(Bytes(report.failure_data.begin(), report.failure_data.end()), c.data) << c.name;
    Written written;
    encode_verification(standard(), report, written.out);
    EXPECT_EQ(written.bytes(), data) << c.name;
  }
}

TEST_F(ServiceVectors, Housekeeping) {
  for (const char* name : {"tc_3_5", "tc_3_6", "tc_3_27"}) {
    const Bytes data = tc(name);
    ReportList list;
    expect_whole_only(data, [&](auto cut) { return decode_report_list(standard(), cut, list); });
    ASSERT_TRUE(decode_report_list(standard(), data, list).ok());
    ASSERT_EQ(list.size(), 2U);
    EXPECT_EQ(list[0], 1U);
    EXPECT_EQ(list[1], 2U);
    Written written;
    encode_report_list(standard(), list, written.out);
    EXPECT_EQ(written.bytes(), data);
  }
  const Bytes data = tc("tc_3_31");
  IntervalList list;
  expect_whole_only(data, [&](auto cut) { return decode_interval_list(standard(), cut, list); });
  ASSERT_TRUE(decode_interval_list(standard(), data, list).ok());
  ASSERT_EQ(list.size(), 1U);
  EXPECT_EQ(list[0].report_id, 1U);
  EXPECT_EQ(list[0].interval_ns, 250 * ns_per_ms);
  Written written;
  encode_interval_list(standard(), list, written.out);
  EXPECT_EQ(written.bytes(), data);
  Written report;
  encode_report_id(standard(), 1, report.out);
  report.out.u16(80);
  report.out.f32(0.5F);
  report.out.u32(100000);
  EXPECT_EQ(report.bytes(), tm("tm_3_25"));
}

TEST_F(ServiceVectors, Events) {
  for (const char* name : {"tc_5_5", "tc_5_6"}) {
    const Bytes data = tc(name);
    EventList list;
    expect_whole_only(data, [&](auto cut) { return decode_event_list(standard(), cut, list); });
    ASSERT_TRUE(decode_event_list(standard(), data, list).ok());
    ASSERT_EQ(list.ids.size(), 2U);
    EXPECT_EQ(list.ids[0], 16U);
    EXPECT_EQ(list.ids[1], 17U);
  }
  Written event;
  encode_event(standard(), 16, from_hex("000186a0"), event.out);
  for (const char* name : {"tm_5_1", "tm_5_2", "tm_5_3", "tm_5_4"}) EXPECT_EQ(event.bytes(), tm(name));
  const std::uint32_t disabled[] = {16, 17};
  Written list;
  encode_disabled_events(standard(), disabled, list.out);
  EXPECT_EQ(list.bytes(), tm("tm_5_8"));
}

TEST_F(ServiceVectors, FunctionsAndTest) {
  FunctionCall call;
  ASSERT_TRUE(decode_function(tc("tc_8_1"), call).ok());
  EXPECT_STREQ(call.name, "CAPTURE");
  EXPECT_TRUE(call.arguments.empty());
  const Bytes with_arguments = tc("tc_8_1_arg");
  ASSERT_TRUE(decode_function(with_arguments, call).ok());
  EXPECT_STREQ(call.name, "CAPTURE");
  EXPECT_EQ(call.arguments.size(), 6U);
  Written written;
  encode_function(call, written.out);
  EXPECT_EQ(written.bytes(), with_arguments);

  std::uint16_t application = 0;
  const Bytes connection = tc("tc_17_3");
  expect_whole_only(connection, [&](auto cut) { return decode_connection(cut, application); });
  ASSERT_TRUE(decode_connection(connection, application).ok());
  EXPECT_EQ(application, apid);
  EXPECT_EQ(connection, tm("tm_17_4")) << "the answer is the question's content";
}

TEST_F(ServiceVectors, InsertIntoTheSchedule) {
  for (const char* name : {"tc_11_4", "tc_11_4_two"}) {
    const Bytes data = tc(name);
    InsertReader reader(standard(), data);
    Written written;
    encode_insert_head(standard(), 0, reader.count(), written.out);
    std::vector<ScheduleItem> items;
    for (ScheduleItem item; reader.next(item);) {
      items.push_back(item);
      EXPECT_TRUE(encode_insert_item(standard(), item, written.out).ok());
    }
    EXPECT_TRUE(reader.status().ok()) << name;
    EXPECT_EQ(written.bytes(), data) << name;
    ASSERT_EQ(items.size(), name == std::string("tc_11_4") ? 1U : 2U);
    EXPECT_EQ(items[0].release, year_2026 + 5001 * ns_per_ms);
    Telecommand request;
    ASSERT_TRUE(decode_telecommand(items[0].packet, apid, request).ok());
    EXPECT_EQ(scheduled_id(request), (ScheduledId{1, apid, 23}));
    EXPECT_EQ(request.ack_flags, 0x09);
    EXPECT_EQ(items.back().release, year_2026 + (items.size() == 2 ? 5251 : 5001) * ns_per_ms);
    const auto read_all = [](std::span<const std::uint8_t> cut) {
      InsertReader all(standard(), cut);
      for (ScheduleItem item; all.next(item);) continue;
      return all.status();
    };
    expect_whole_only(data, read_all);
  }
}

TEST_F(ServiceVectors, InsertInOtherTailorings) {
  Tailoring sub8 = standard();
  sub8.sub_schedule = 1;
  sub8.insert_count = 1;
  const Bytes data = tc("tc_11_4_sub8");
  InsertReader reader(sub8, data);
  ScheduleItem item;
  ASSERT_TRUE(reader.next(item));
  EXPECT_EQ(item.sub_schedule, 3U);
  EXPECT_FALSE(reader.next(item));
  EXPECT_TRUE(reader.status().ok());

  const auto other = golden_vectors("tc_fsfw.hex");
  ASSERT_FALSE(other.empty());
  const Bytes without_count = telecommand_data(other.at("fsfw_11_4"));
  InsertReader one(fsfw(), without_count);
  ASSERT_TRUE(one.next(item));
  EXPECT_EQ(item.release, year_2026 + 5001 * ns_per_ms);
  EXPECT_FALSE(one.next(item));
  EXPECT_TRUE(one.status().ok());
  EventList events;
  EXPECT_TRUE(decode_event_list(fsfw(), telecommand_data(other.at("fsfw_5_5")), events).ok());
  EXPECT_TRUE(events.all);
}

TEST_F(ServiceVectors, ScheduleRequests) {
  ScheduledIdList ids;
  const Bytes remove = tc("tc_11_5");
  expect_whole_only(remove, [&](auto cut) { return decode_scheduled_ids(standard(), cut, ids); });
  ASSERT_TRUE(decode_scheduled_ids(standard(), remove, ids).ok());
  ASSERT_EQ(ids.size(), 1U);
  EXPECT_EQ(ids[0], (ScheduledId{1, apid, 23}));
  std::int32_t ms = 0;
  const Bytes shift = tc("tc_11_7");
  expect_whole_only(shift, [&](auto cut) { return decode_shift(standard(), cut, ms, ids); });
  ASSERT_TRUE(decode_shift(standard(), shift, ms, ids).ok());
  EXPECT_EQ(ms, 2500);
  ASSERT_EQ(ids.size(), 2U);
  EXPECT_EQ(ids[1], (ScheduledId{1, apid, 24}));
  ms = 0;
  ASSERT_TRUE(decode_shift_all(tc("tc_11_15"), ms).ok());
  EXPECT_EQ(ms, 2500);
}

TEST_F(ServiceVectors, ScheduleReports) {
  ScheduleItem first, second;
  first.release = year_2026 + 5001 * ns_per_ms;
  first.id = {1, apid, 23};
  second.release = year_2026 + 5251 * ns_per_ms;
  second.id = {1, apid, 24};
  Written summary;
  encode_report_head(standard(), 2, summary.out);
  EXPECT_TRUE(encode_summary_item(standard(), first, summary.out).ok());
  EXPECT_TRUE(encode_summary_item(standard(), second, summary.out).ok());
  EXPECT_EQ(summary.bytes(), tm("tm_11_13"));
  const Bytes request = from_hex("18efc01700102908010001434150545552450000502f91");
  first.packet = request;
  Written detail;
  encode_report_head(standard(), 1, detail.out);
  EXPECT_TRUE(encode_detail_item(standard(), first, detail.out).ok());
  EXPECT_EQ(detail.bytes(), tm("tm_11_10"));
}

TEST_F(ServiceVectors, Parameters) {
  ParameterList list;
  const Bytes report = tc("tc_20_1");
  expect_whole_only(report, [&](auto cut) { return decode_parameter_list(standard(), cut, list); });
  ASSERT_TRUE(decode_parameter_list(standard(), report, list).ok());
  ASSERT_EQ(list.size(), 3U);
  EXPECT_EQ(list[2], 3U);
  const Bytes set = tc("tc_20_3");
  ByteReader in(set);
  EXPECT_EQ(read_count(standard().parameter_count, in), 3U);
  EXPECT_EQ(in.number(standard().parameter_id), 1U);
  EXPECT_EQ(read_value(FieldType::u16, in), 80);
  EXPECT_EQ(in.number(standard().parameter_id), 2U);
  EXPECT_EQ(read_value(FieldType::f32, in), 0.5);
  EXPECT_EQ(in.number(standard().parameter_id), 3U);
  EXPECT_EQ(read_value(FieldType::u32, in), 100000);
  EXPECT_TRUE(in.ok());
  EXPECT_EQ(in.left(), 0U);
  Written values;
  write_count(standard().parameter_count, 3, values.out);
  values.out.number(1, 2);
  write_value(FieldType::u16, 80, values.out);
  values.out.number(2, 2);
  write_value(FieldType::f32, 0.5, values.out);
  values.out.number(3, 2);
  write_value(FieldType::u32, 100000, values.out);
  EXPECT_EQ(values.bytes(), tm("tm_20_2"));
}

TEST(Services, FailureCodeOfTheYamcsTailoringHasFourOctets) {
  VerificationReport report{.subtype = verification::completion_failed, .request = 0x18EFC017, .code = 258};
  Written written;
  encode_verification(yamcs(), report, written.out);
  EXPECT_EQ(written.bytes(), from_hex("18efc017 00000102"));
}

TEST(Services, FunctionNamesAreZeroPaddedOrRejected) {
  FunctionCall call;
  ASSERT_TRUE(decode_function(from_hex("4142434445464748 01"), call).ok());
  EXPECT_STREQ(call.name, "ABCDEFGH");
  EXPECT_EQ(call.arguments.size(), 1U);
  EXPECT_TRUE(decode_function(from_hex("4142434445464700 01"), call).ok());
  EXPECT_FALSE(decode_function(from_hex("4142004445464700"), call).ok());
  EXPECT_FALSE(decode_function(from_hex("41424344454647"), call).ok());
}

TEST(Services, ListsAreBounded) {
  Bytes many = {0xFF, 0xFF};
  many.resize(2 + 2 * 65535, 1);
  ParameterList parameters;
  EXPECT_TRUE(decode_parameter_list(standard(), many, parameters).is(StatusCode::capacity_exceeded));
  EventList events;
  EXPECT_TRUE(decode_event_list(standard(), many, events).is(StatusCode::capacity_exceeded));
  ScheduledIdList ids;
  EXPECT_TRUE(decode_scheduled_ids(standard(), many, ids).is(StatusCode::capacity_exceeded));
  ReportList reports;
  EXPECT_TRUE(decode_report_list(standard(), many, reports).is(StatusCode::capacity_exceeded));
}

TEST(Services, IntervalsOfTheFsfwTailoringAreSeconds) {
  IntervalList list;
  ASSERT_TRUE(decode_interval_list(fsfw(), from_hex("0000002a00000007 3f000000"), list).ok());
  ASSERT_EQ(list.size(), 1U);
  EXPECT_EQ(list[0].report_id, 0x2A00000007U);
  EXPECT_EQ(list[0].interval_ns, 500 * ns_per_ms);
  for (const char* bad : {"7fc00000", "bf800000", "7f800000"}) {
    EXPECT_TRUE(decode_interval_list(fsfw(), from_hex(std::string("0000002a00000007 ") + bad), list)
                    .is(StatusCode::invalid_argument));
  }
}

TEST(Services, ValuesAreHeldWithinTheirType) {
  Written written;
  write_value(FieldType::u8, 256, written.out);
  write_value(FieldType::u8, -1, written.out);
  write_value(FieldType::u16, 2.6, written.out);
  write_value(FieldType::f64, 1.5, written.out);
  EXPECT_EQ(written.bytes(), from_hex("ff 00 0003 3ff8000000000000"));
}

}  // namespace
}  // namespace ilp
