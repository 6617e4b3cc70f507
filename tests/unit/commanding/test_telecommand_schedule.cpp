// Service 11: telecommands that wait for their time, as a ground station sees them.
#include <gtest/gtest.h>

#include "fsw/commanding/settings.hpp"
#include "tests/unit/commanding/telecommand_fixture.hpp"

namespace ilp::test {
namespace {

constexpr TimeNs s = ns_per_s;

class TelecommandScheduleTest : public TelecommandTest {
 protected:
  using Item = std::pair<TimeNs, Bytes>;
  Bytes insertion(const std::vector<Item>& items) {
    Bytes data = numbers({{items.size(), 2}});
    for (const auto& [release, request] : items) data = data + time_of(release) + request;
    return data;
  }
  void insert(const std::vector<Item>& items) { send(11, 4, insertion(items)); }
  /// Each of them a ping.
  std::vector<std::uint16_t> insert_pings(const std::vector<TimeNs>& releases) {
    std::vector<Item> items;
    std::vector<std::uint16_t> sequences;
    for (const TimeNs release : releases) {
      sequences.push_back(count);
      items.emplace_back(release, packet(17, 1, {}, 1, ack::completion));
    }
    insert(items);
    step();
    EXPECT_EQ(types(), "1.1 1.3 1.7");
    return sequences;
  }
  /// (time, sequence count) of what the schedule says it holds.
  std::vector<std::pair<TimeNs, int>> summary() {
    send(11, 17, {}, 1, 0);
    step();
    std::vector<std::pair<TimeNs, int>> held;
    for (const Report& report : received()) {
      EXPECT_TRUE(report == std::make_pair(11, 13));
      ByteReader in(report.data);
      const int items = in.u16();
      for (int i = 0; i < items; ++i) {
        UtcNs utc = 0;
        EXPECT_TRUE(decode_time(TimeFormat{}, in, utc).ok());
        EXPECT_EQ(in.u16(), 1);
        EXPECT_EQ(in.u16(), apid);
        held.emplace_back(writer->settings().time.mission(utc), in.u16());
      }
      EXPECT_TRUE(in.ok());
      EXPECT_EQ(in.left(), 0U);
    }
    return held;
  }
  Bytes name_of(std::uint16_t sequence) { return numbers({{1, 2}, {apid, 2}, {sequence, 2}}); }
};

TEST_F(TelecommandScheduleTest, RequestsRunAtTheirTimeInOrder) {
  const auto pings = insert_pings({5 * s, 3 * s, 3 * s + 100 * ns_per_ms});
  step_at(3 * s - 1);
  EXPECT_EQ(types(), "");
  step_at(3 * s);
  EXPECT_EQ(types(), "17.2 1.7");
  EXPECT_EQ(request_of(last_report[1]), request_of(pings[1]));
  step_at(3 * s + 100 * ns_per_ms);
  EXPECT_EQ(types(), "17.2 1.7");
  EXPECT_EQ(request_of(last_report[1]), request_of(pings[2]));
  step_at(5 * s + 99 * ns_per_ms);
  EXPECT_EQ(types(), "17.2 1.7");
  EXPECT_EQ(request_of(last_report[1]), request_of(pings[0]));
  step_at(10 * s);
  EXPECT_EQ(types(), "");
  EXPECT_EQ(number_of<ScheduledRecord>(), 0);
}

TEST_F(TelecommandScheduleTest, ACaptureIsCommandedAheadForItsExactTimeAndToldThen) {
  insert({{4 * s + 37 * ns_per_ms, packet(8, 1, function("CAPTURE"))},
          {4 * s + 137 * ns_per_ms, packet(8, 1, function("CAPTURE"))}});
  step();
  received();
  for (TimeNs now = 2900 * ns_per_ms; now <= 4 * s; now += minor_frame_ns) step_at(now);
  EXPECT_EQ(types(), "");
  ASSERT_EQ(number_of<CommandRecord>(), 2);
  EXPECT_EQ(read<CommandRecord>(1).at_ns, 4037 * ns_per_ms);
  EXPECT_EQ(read<CommandRecord>(1).time_ns, 3100 * ns_per_ms);
  EXPECT_EQ(read<CommandRecord>(2).at_ns, 4137 * ns_per_ms);
  // Over a restart too, and whatever is known of it before.
  answer_capture(read<CommandRecord>(1), CaptureState::exposed);
  answer_capture(read<CommandRecord>(2), CaptureState::rejected, StatusCode::capture_too_soon);
  begin();
  step_at(4036 * ns_per_ms);
  EXPECT_EQ(types(), "");
  step_at(4100 * ns_per_ms);
  EXPECT_EQ(types(), "1.1 1.3 1.7");
  step_at(4200 * ns_per_ms);
  EXPECT_EQ(types(), "1.1 1.3 1.8");
  step_at(9 * s);
  EXPECT_EQ(types(), "");
}

TEST_F(TelecommandScheduleTest, ACaptureThatCannotBeCommandedIsToldAtOnce) {
  for (std::size_t i = 0; i < limits::max_open_requests; ++i) {
    send(8, 1, function("CAPTURE"));
    if (i % 16 == 15) step_at(clock.now() + minor_frame_ns);
  }
  insert({{5 * s, packet(8, 1, function("CAPTURE"))}});
  step();
  received();
  step_at(4500 * ns_per_ms);
  EXPECT_EQ(types(), "1.1 1.4");
  EXPECT_EQ(code_of(last_report[1]), StatusCode::requests_full);
}

TEST_F(TelecommandScheduleTest, TwentyCapturesAreReportedEachByItsOwnRequest) {
  std::vector<Item> items;
  std::vector<std::uint16_t> sequences;
  for (int i = 0; i < 20; ++i) {
    sequences.push_back(count);
    items.emplace_back(10 * s + i * 100 * ns_per_ms, packet(8, 1, function("CAPTURE"), 1, ack::completion));
  }
  insert(items);
  step();
  EXPECT_EQ(types(), "1.1 1.3 1.7");
  std::int64_t answered = 0;
  std::vector<std::uint32_t> completed;
  for (TimeNs now = 9 * s; now < 14 * s; now += minor_frame_ns) {
    step_at(now);
    while (answered < number_of<CommandRecord>())
      answer_capture(read<CommandRecord>(++answered), CaptureState::exposed);
    for (const Report& report : received()) {
      EXPECT_TRUE(report == std::make_pair(1, 7));
      completed.push_back(request_of(report));
    }
  }
  ASSERT_EQ(completed.size(), 20U);
  for (std::size_t i = 0; i < 20; ++i) EXPECT_EQ(completed[i], request_of(sequences[i]));
}

TEST_F(TelecommandScheduleTest, WhatCannotBeScheduledIsRefusedAsAWhole) {
  clock.set(10 * s);
  const auto refused = [&](const Bytes& data) {
    send(11, 4, data);
    step();
    EXPECT_EQ(number_of<ScheduledRecord>(), 0);
    return failure();
  };
  const Bytes ping = packet(17, 1);
  EXPECT_EQ(refused(insertion({{20 * s, ping}, {9 * s, ping}})), "1.4 release_in_past");
  EXPECT_EQ(value_of(last_report.back(), 0), 1000);
  EXPECT_EQ(value_of(last_report.back(), 1), 1);
  Bytes damaged = ping;
  damaged.back() ^= 1;
  EXPECT_EQ(refused(insertion({{20 * s, damaged}})), "1.4 packet_crc");
  EXPECT_EQ(refused(insertion({{20 * s, packet(77, 1)}})), "1.4 service_unknown");
  Bytes cut = insertion({{20 * s, ping}});
  cut.resize(cut.size() - 1);
  EXPECT_EQ(refused(cut), "1.2 request_malformed");
  EXPECT_EQ(refused(insertion({})), "1.2 request_malformed");
  EXPECT_EQ(refused({}), "1.2 request_malformed");
  const Bytes large = packet(8, 1, Bytes(limits::max_scheduled_bytes, 65));
  EXPECT_EQ(refused(insertion({{20 * s, large}})), "1.4 capacity_exceeded");
}

TEST_F(TelecommandScheduleTest, TheScheduleIsBoundedAndReportedWhole) {
  constexpr std::size_t half = limits::max_scheduled / 2;
  std::vector<Item> items;
  for (std::size_t i = 0; i < half; ++i) items.emplace_back(100 * s - static_cast<TimeNs>(i) * s / 10, packet(17, 1));
  insert(items);
  insert(items);
  step();
  EXPECT_EQ(failure(), "");
  const auto held = summary();
  ASSERT_EQ(held.size(), limits::max_scheduled);
  for (std::size_t i = 1; i < held.size(); ++i) EXPECT_LE(held[i - 1].first, held[i].first);
  insert({{50 * s, packet(17, 1)}});
  step();
  EXPECT_EQ(failure(), "1.4 schedule_full");
  EXPECT_EQ(number_of<ScheduledRecord>(), static_cast<std::int64_t>(limits::max_scheduled));
}

TEST_F(TelecommandScheduleTest, TheScheduleSurvivesARestartInTheMiddle) {
  insert_pings({2 * s, 4 * s, 60 * s});
  step_at(2 * s);
  EXPECT_EQ(types(), "17.2 1.7");
  begin();
  step_at(4 * s);
  EXPECT_EQ(types(), "17.2 1.7");
  // What came due while the package stood still is not carried out late, and its sender gets a report.
  begin();
  step_at(62 * s);
  EXPECT_EQ(failure(), "1.4 release_missed");
  EXPECT_EQ(value_of(last_report.back(), 0), 2000);
  EXPECT_EQ(number_of<ScheduledRecord>(), 0);
}

TEST_F(TelecommandScheduleTest, DeletingByName) {
  const auto pings = insert_pings({5 * s, 6 * s, 7 * s});
  EXPECT_EQ(failure_after(11, 5, numbers({{2, 2}}) + name_of(pings[0]) + name_of(9999)), "1.4 schedule_unknown");
  EXPECT_EQ(value_of(last_report.back(), 0), 1);
  EXPECT_EQ(summary().size(), 3U);
  EXPECT_EQ(types_after(11, 5, numbers({{2, 2}}) + name_of(pings[0]) + name_of(pings[2])), "1.1 1.3 1.7");
  EXPECT_EQ(summary(), (std::vector<std::pair<TimeNs, int>>{{6 * s, pings[1]}}));
}

TEST_F(TelecommandScheduleTest, ShiftingSomeAndAll) {
  const auto pings = insert_pings({5 * s, 6 * s});
  EXPECT_EQ(types_after(11, 7, numbers({{2500, 4}, {1, 2}}) + name_of(pings[0])), "1.1 1.3 1.7");
  EXPECT_EQ(summary(), (std::vector<std::pair<TimeNs, int>>{{6 * s, pings[1]}, {7500 * ns_per_ms, pings[0]}}));
  EXPECT_EQ(types_after(11, 15, numbers({{static_cast<std::uint32_t>(-1000), 4}})), "1.1 1.3 1.7");
  EXPECT_EQ(summary(), (std::vector<std::pair<TimeNs, int>>{{5 * s, pings[1]}, {6500 * ns_per_ms, pings[0]}}));
  EXPECT_EQ(failure_after(11, 15, numbers({{static_cast<std::uint32_t>(-6000), 4}})), "1.4 release_in_past");
  EXPECT_EQ(summary().size(), 2U);
  begin();
  EXPECT_EQ(summary(), (std::vector<std::pair<TimeNs, int>>{{5 * s, pings[1]}, {6500 * ns_per_ms, pings[0]}}));
  // Farther and farther: refused before it overflows.
  std::string refused;
  for (int i = 0; i < 2000 && refused.empty(); ++i) {
    send(11, 15, numbers({{0x7FFFFFFF, 4}}), 1, 0);
    clock.set(clock.now() + ns_per_ms);
    step();
    refused = failure();
  }
  EXPECT_EQ(refused, "1.4 time_out_of_range");
}

TEST_F(TelecommandScheduleTest, DisabledNothingIsReleasedAndResetForgets) {
  insert_pings({2 * s, 30 * s});
  send(11, 2);
  step();
  received();
  step_at(2 * s);
  EXPECT_EQ(failure(), "1.4 release_missed");
  begin();
  EXPECT_EQ(types_after(11, 1), "1.1 1.3 1.7");
  step_at(30 * s);
  EXPECT_EQ(types(), "17.2 1.7");
  insert_pings({50 * s});
  EXPECT_EQ(types_after(11, 3), "1.1 1.3 1.7");
  EXPECT_TRUE(summary().empty());
  EXPECT_EQ(number_of<ScheduledRecord>(), 0);
  step();
  for (int i = 0; i < 60; ++i) EXPECT_TRUE(telecommander->step().status.ok());
  EXPECT_EQ(read<CommandingRecord>(1).schedule_enabled, 0);
  EXPECT_EQ(failure_after(11, 3, {1}), "1.2 request_malformed");
}

TEST_F(TelecommandScheduleTest, DetailReportsHoldTheRequests) {
  const Bytes ping = packet(17, 1);
  const std::uint16_t sequence = count - 1;
  insert({{5 * s, ping}, {6 * s, packet(17, 3, {0, 0xEF})}});
  step();
  received();
  EXPECT_EQ(types_after(11, 16), "1.1 1.3 11.10 1.7");
  ByteReader in(last_report[2].data);
  EXPECT_EQ(in.u16(), 2);
  const auto release = in.take(7);
  EXPECT_EQ(Bytes(release.begin(), release.end()), time_of(5 * s));
  const auto first = in.take(ping.size());
  EXPECT_EQ(Bytes(first.begin(), first.end()), ping);
  EXPECT_EQ(types_after(11, 9, numbers({{1, 2}}) + name_of(sequence)), "1.1 1.3 11.10 1.7");
  EXPECT_EQ(last_report[2].data, numbers({{1, 2}}) + time_of(5 * s) + ping);
  EXPECT_EQ(types_after(11, 12, numbers({{1, 2}}) + name_of(sequence)), "1.1 1.3 11.13 1.7");
  EXPECT_EQ(last_report[2].data, numbers({{1, 2}}) + time_of(5 * s) + name_of(sequence));
}

TEST_F(TelecommandScheduleTest, LongDetailsGoInSeveralReports) {
  const Bytes large = packet(20, 1, numbers({{20, 2}}) + Bytes(40, 1));
  std::vector<Item> items(40, Item{50 * s, large});
  insert(items);
  step();
  received();
  send(11, 16, {}, 1, 0);
  step();
  int reported = 0;
  const auto reports = received();
  EXPECT_GT(reports.size(), 1U);
  for (const Report& report : reports) {
    const int held = report.data[0] << 8 | report.data[1];
    EXPECT_EQ(report.data.size(), 2U + static_cast<std::size_t>(held) * (7 + large.size()));
    reported += held;
  }
  EXPECT_EQ(reported, 40);
}

TEST_F(TelecommandScheduleTest, AScheduledRequestThatFailsIsReportedUnderItsOwnName) {
  const std::uint16_t sequence = count;
  insert({{5 * s, packet(8, 1, function("NOSUCH"), 4)}});
  step();
  received();
  step_at(5 * s);
  EXPECT_EQ(types(), "1.1 1.4");
  EXPECT_EQ(request_of(last_report[1]), request_of(sequence));
  EXPECT_EQ(last_report[1].destination, 4);
  EXPECT_EQ(number_of<ScheduledRecord>(), 0);
  step_at(6 * s);
  EXPECT_EQ(types(), "");
}

TEST_F(TelecommandScheduleTest, ScheduledRequestsMayScheduleOthersAndSetParameters) {
  const std::uint16_t id = id_of("motion", "corners");
  insert({{5 * s, packet(11, 4, insertion({{8 * s, packet(20, 3, numbers({{1, 2}, {id, 2}, {444, 2}}))}}))}});
  step();
  EXPECT_EQ(types(), "1.1 1.3 1.7");
  step_at(5 * s);
  EXPECT_EQ(types(), "1.1 1.3 1.7");
  EXPECT_EQ(number_of<ScheduledRecord>(), 1);
  step_at(8 * s);
  EXPECT_EQ(types(), "1.1 1.3 1.7");
  EXPECT_EQ(mission.corners, 444);
}

TEST_F(TelecommandScheduleTest, ManyThatAreDueAtOnceAllRun) {
  std::vector<Item> items;
  for (std::size_t i = 0; i < limits::max_scheduled; ++i) items.emplace_back(5 * s, packet(17, 1, {}, 1, 0));
  send(11, 4, insertion(items));
  step();
  received();
  std::size_t run = 0;
  for (int i = 0; i < 4; ++i) {
    clock.set(5 * s + i * minor_frame_ns);
    EXPECT_TRUE(telecommander->step().status.ok());
    run += received().size();
  }
  EXPECT_EQ(run, limits::max_scheduled);
}

TEST_F(TelecommandScheduleTest, AScheduledRequestWaitsForTheLockOfTheStoreAndIsReportedWhenItIsTooLate) {
  const std::uint16_t early = count;
  insert({{5 * s, packet(8, 1, function("FLUSH"), 4)}});
  const std::uint16_t late = count;
  insert({{9 * s, packet(8, 1, function("FLUSH"), 4)}});
  step();
  received();
  failing.lock();
  for (TimeNs now = 5 * s; now < 10 * s; now += minor_frame_ns) {
    clock.set(now);
    telecommander->step();
  }
  EXPECT_EQ(types(), "");
  failing.recover();
  step_at(9 * s + 9 * minor_frame_ns);
  ASSERT_EQ(failure(), "1.4 release_missed");
  int started = 0;
  for (const Report& report : last_report) {
    if (report.service != 1) continue;
    if (report.subtype == 4) {
      EXPECT_EQ(request_of(report), request_of(early));
    }
    if (report.subtype != 3) continue;
    ++started;
    EXPECT_EQ(request_of(report), request_of(late));
  }
  EXPECT_EQ(started, 1) << "the other one is carried out, once";
  EXPECT_EQ(number_of<ScheduledRecord>(), 0);
}

}  // namespace
}  // namespace ilp::test
