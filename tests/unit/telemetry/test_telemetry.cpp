// Services 3 and 5 as a ground station sees them. Octets are read here by offsets written down by hand, not by the
// tables that the component follows.
#include "fsw/telemetry/telemetry.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <map>
#include <set>

#include "fsw/base/crc.hpp"
#include "fsw/downlink/file_delivery.hpp"
#include "fsw/executive/event_log.hpp"
#include "fsw/packets/message_table.hpp"
#include "tests/support/golden_vectors.hpp"
#include "tests/unit/commanding/telecommand_fixture.hpp"

namespace ilp::test {
namespace {

constexpr std::uint8_t sid_status = 1, sid_components = 2, sid_link = 3, sid_storage = 5, sid_capture = 6,
                       sid_nodes = 21, sid_pose = 13;
constexpr TimeNs frame = 100 * ns_per_ms;

class FakeHealth final : public Health {
 public:
  [[nodiscard]] const ComponentStats& stats(ComponentId component) const override {
    return stats_[static_cast<std::size_t>(component) - 1];
  }
  [[nodiscard]] bool runs(ComponentId component) const override { return component != elsewhere; }
  [[nodiscard]] std::uint32_t frame_overruns() const override { return 3; }
  [[nodiscard]] std::int64_t frames_run() const override { return 1234; }
  FakeHealth() {
    for (std::size_t i = 0; i < component_numbers; ++i) {
      stats_[i].steps = static_cast<std::uint32_t>(100 + i);
      stats_[i].restarts = 7;
      stats_[i].longest_ns = 5 * ns_per_ms;
    }
  }

  ComponentId elsewhere = ComponentId::none;  ///< it runs in another process

 private:
  std::array<ComponentStats, component_numbers> stats_;
};

class TelemetryTest : public TelecommandTest {
 protected:
  void SetUp() override {
    TelecommandTest::SetUp();
    start();
  }
  void start() {
    telemetry = std::make_unique<TelemetryReporter>(failing, *router, *writer, clock, mission,
                                                    TelemetrySources{&health, &delivery});
    ASSERT_TRUE(telemetry->restore().ok());
  }
  /// As after a power cut.
  void restart() {
    begin();
    start();
  }
  void run_frame() {
    step();
    const StepResult result = telemetry->step();
    EXPECT_TRUE(result.status.ok()) << status_name(result.status.code);
  }
  /// What comes down in the minor frame after this telecommand.
  std::string types_after(int service, int subtype, const Bytes& data = {}) {
    send(service, subtype, data);
    run_frame();
    return types();
  }
  std::string failure_after(int service, int subtype, const Bytes& data = {}) {
    send(service, subtype, data);
    run_frame();
    return failure();
  }
  void run_until(TimeNs end) {
    for (; clock.now() < end; clock.set(clock.now() + frame)) run_frame();
  }
  /// The reports of housekeeping that have come: SID and mission time in ms.
  std::vector<std::pair<int, TimeNs>> housekeeping_received() {
    std::vector<std::pair<int, TimeNs>> list;
    for (const Report& report : last_report = received()) {
      if (report.service != 3) continue;
      EXPECT_EQ(report.subtype, 25);
      EXPECT_EQ(report.destination, 0);
      list.emplace_back(report.data.at(0), (report.time - writer->settings().time.utc(0)) / ns_per_ms);
    }
    return list;
  }
  Bytes one_shot(std::uint8_t sid) {
    EXPECT_EQ(types_after(3, 27, {0, 1, sid}).substr(0, 12), "1.1 1.3 3.25");
    const Bytes data = last_report.size() >= 3 ? last_report[2].data : Bytes{};
    run_frame();
    EXPECT_EQ(types().substr(0, 3), "1.7");
    return data;
  }
  void raise(StatusCode code, std::int64_t a = 0, std::int64_t b = 0, const char* component = "acquisition") {
    log.report(clock.now(), component, {code, a, b});
  }

  FakeHealth health;
  DeliveryCounts delivery;
  EventLog log{store};
  std::unique_ptr<TelemetryReporter> telemetry;
};

/// Big-endian, at an offset.
std::uint64_t at(const Bytes& data, std::size_t offset, std::size_t octets) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < octets; ++i) value = (value << 8U) | data.at(offset + i);
  return value;
}
double real_at(const Bytes& data, std::size_t offset) {
  return std::bit_cast<double>(at(data, offset, 8));
}

TEST_F(TelemetryTest, NothingIsReportedUnasked) {
  run_until(60 * ns_per_s);
  EXPECT_EQ(types(), "");
}

TEST_F(TelemetryTest, APeriodicReportKeepsItsIntervalWithinAMinorFrame) {
  clock.set(ns_per_s);
  send(3, 31, {0, 1, sid_storage, 0, 0, 0x01, 0xC2});  // 450 ms
  send(3, 5, {0, 1, sid_storage});
  run_until(ns_per_s + frame);
  EXPECT_EQ(types(), "1.1 1.3 1.7 1.1 1.3 1.7 3.25");
  run_until(10 * ns_per_s + ns_per_s);
  const auto reports = housekeeping_received();
  // 1450, 1900, ... at the first minor frame at or after it, without drift.
  ASSERT_EQ(reports.size(), 22U);
  for (std::size_t i = 0; i < reports.size(); ++i) {
    const TimeNs due = 1000 + 450 * static_cast<TimeNs>(i + 1);
    EXPECT_EQ(reports[i].first, sid_storage);
    EXPECT_EQ(reports[i].second, (due + 99) / 100 * 100);
  }
  send(3, 6, {0, 1, sid_storage});
  run_until(20 * ns_per_s);
  EXPECT_EQ(types(), "1.1 1.3 1.7");
}

TEST_F(TelemetryTest, ReportsHaveIntervalsOfTheirOwn) {
  send(3, 31, {0, 2, sid_status, 0, 0, 0x03, 0xE8, sid_link, 0, 0, 0x07, 0xD0});  // 1 s and 2 s
  send(3, 5, {0, 3, sid_status, sid_link, sid_pose});
  run_until(20 * ns_per_s);
  std::map<int, int> counted;
  for (const auto& [sid, time] : housekeeping_received()) ++counted[sid];
  EXPECT_EQ(counted, (std::map<int, int>{{sid_status, 20}, {sid_link, 10}, {sid_pose, 2}}));
}

TEST_F(TelemetryTest, AShorterIntervalTakesEffectAtOnce) {
  send(3, 31, {0, 1, sid_status, 0, 0x36, 0xEE, 0x80});  // an hour
  send(3, 5, {0, 1, sid_status});
  run_until(5 * ns_per_s);
  EXPECT_EQ(housekeeping_received().size(), 1U);
  send(3, 31, {0, 1, sid_status, 0, 0, 0x03, 0xE8});
  run_until(10 * ns_per_s);
  EXPECT_EQ(housekeeping_received().size(), 4U);  // 6, 7, 8, 9 s
}

TEST_F(TelemetryTest, AListIsDoneWholeOrNotAtAll) {
  send(3, 5, {0, 2, sid_status, 99});
  run_until(2 * ns_per_s);
  EXPECT_EQ(failure(), "1.4 report_unknown");
  EXPECT_EQ(value_of(last_report[1], 0), 99);
  EXPECT_EQ(value_of(last_report[1], 1), 1);
  EXPECT_EQ(last_report.size(), 2U) << "nothing was enabled";
  for (const int subtype : {6, 27}) {
    EXPECT_EQ(failure_after(3, subtype, {0, 2, sid_status, 0}), "1.4 report_unknown") << subtype;
  }
  EXPECT_EQ(failure_after(3, 31, {0, 2, sid_status, 0, 0, 0x03, 0xE8, sid_link, 0, 0, 0, 99}), "1.4 report_interval");
  EXPECT_EQ(value_of(last_report[1], 0), 99);
  EXPECT_EQ(value_of(last_report[1], 1), 1);
}

TEST_F(TelemetryTest, WhatHasNotTheFormOfItsRequestIsNotAccepted) {
  const std::pair<int, Bytes> bad[] = {{5, {}},         {5, {0, 0}},  {5, {0, 2, 1}},           {27, {0, 1, 1, 1}},
                                       {31, {0, 1, 1}}, {31, {0, 0}}, {31, {0, 1, 1, 0, 0, 1}}, {5, {0xFF, 0xFF, 1}}};
  for (const auto& [subtype, data] : bad) {
    send(3, subtype, data);
    run_frame();
    const std::string said = failure();
    EXPECT_TRUE(said == "1.2 request_malformed" || said == "1.2 capacity_exceeded") << subtype << " " << said;
  }
  EXPECT_EQ(failure_after(3, 1), "1.2 subtype_unknown");
  EXPECT_EQ(failure_after(5, 1), "1.2 subtype_unknown");
  EXPECT_EQ(failure_after(5, 7, {0}), "1.2 request_malformed");
}

TEST_F(TelemetryTest, WhatIsAskedForSurvivesARestart) {
  send(3, 31, {0, 1, sid_link, 0, 0, 0x01, 0xF4});
  send(3, 5, {0, 1, sid_link});
  const auto code = static_cast<std::uint8_t>(StatusCode::frame_gap);
  send(5, 6, {0, 1, 0, code});
  run_frame();
  raise(StatusCode::strip_broken);
  run_frame();
  received();
  restart();
  const TimeNs begun = clock.now();
  raise(StatusCode::frame_gap);
  run_until(begun + 5 * ns_per_s);
  EXPECT_EQ(housekeeping_received().size(), 10U);
  EXPECT_EQ(last_report.size(), 10U) << "no event: one was told before, the other is disabled";
  send(5, 7);
  run_frame();
  run_frame();
  static_cast<void>(types());
  ASSERT_EQ(last_report.size(), 5U);
  EXPECT_EQ(last_report[2].data, (Bytes{0, 1, 0, code}));
}

TEST_F(TelemetryTest, ARequestActsThroughRecordsAndIsCompletedWhenTheReportIsMade) {
  EXPECT_EQ(TelecommandTest::types_after(3, 27, {0, 2, sid_status, sid_link}), "1.1 1.3")
      << "telemetry has not run yet";
  EXPECT_EQ(last_command().kind, CommandKind::report_once);
  EXPECT_EQ(last_command().subject_id, sid_link);
  // A power cut between the request and the report.
  restart();
  run_frame();
  run_frame();
  EXPECT_EQ(types(), "3.25 3.25 1.7");
}

TEST_F(TelemetryTest, ARequestThatTelemetryDoesNotObeyFails) {
  EXPECT_EQ(TelecommandTest::types_after(5, 7), "1.1 1.3");
  step_at(clock.now() + 11 * ns_per_s);
  EXPECT_EQ(failure(), "1.8 no_completion");
}

TEST_F(TelemetryTest, AReportShowsTheNewestRecord) {
  EXPECT_EQ(one_shot(sid_capture), Bytes({sid_capture}) + Bytes(84, 0)) << "there is none yet";
  CaptureRecord capture;
  capture.id = 3;
  capture.requested_ns = 0x0102030405060708;
  capture.issued_ns = -2;
  capture.source = CaptureSource::telecommand;
  capture.state = CaptureState::exposed;
  capture.command_id = 5;
  capture.frame_id = 7;
  capture.exposed_ns = 11;
  capture.overlap = 0.75;
  capture.overlap_sigma = 0.5;
  capture.speed_px_s = -1.25;
  capture.reason = 0x1234;
  capture.distance_m = 2.5;
  write(capture);
  capture.id = 2;
  write(capture);
  const Bytes data = one_shot(sid_capture);
  ASSERT_EQ(data.size(), 1U + 84);
  EXPECT_EQ(at(data, 1, 8), 3U);
  EXPECT_EQ(at(data, 9, 8), 0x0102030405060708U);
  EXPECT_EQ(at(data, 17, 8), 0xFFFFFFFFFFFFFFFEU);
  EXPECT_EQ(at(data, 25, 2), 0x0401U) << "telecommand, exposed";
  EXPECT_EQ(at(data, 27, 8), 5U);
  EXPECT_EQ(at(data, 35, 8), 7U);
  EXPECT_EQ(at(data, 43, 8), 11U);
  EXPECT_EQ(real_at(data, 51), 0.75);
  EXPECT_EQ(real_at(data, 59), 0.5);
  EXPECT_EQ(real_at(data, 67), -1.25);
  EXPECT_EQ(at(data, 75, 2), 0x1234U);
  EXPECT_EQ(real_at(data, 77), 2.5);
}

TEST_F(TelemetryTest, TheStatusOfThePackageHasItsLayout) {
  clock.set(12'345 * ns_per_ms);
  raise(StatusCode::strip_broken);
  raise(StatusCode::strip_broken);
  send(5, 6, {0, 2, 0, 3, 0, 4});
  run_frame();
  received();
  raise(StatusCode::strip_broken);
  const Bytes data = one_shot(sid_status);
  ASSERT_EQ(data.size(), 1U + 36);
  EXPECT_EQ(data[0], sid_status);
  EXPECT_EQ(at(data, 1, 8), 12'345'000'000U);
  EXPECT_EQ(at(data, 12, 1), 1U) << "contact";
  Bytes values;
  for (std::size_t number = 1; number < 1000; ++number) {
    const std::size_t i = find_parameter(number);
    if (i == parameter_count()) continue;
    const auto bits = std::bit_cast<std::uint64_t>(parameter_value(mission, i));
    for (int shift = 56; shift >= 0; shift -= 8) values.push_back(static_cast<std::uint8_t>(bits >> shift));
  }
  EXPECT_EQ(at(data, 13, 4), crc32(values));
  EXPECT_EQ(at(data, 25, 4), 3U) << "events";
  EXPECT_EQ(at(data, 29, 4), 1U) << "not told";
  EXPECT_EQ(at(data, 33, 4), 2U) << "disabled";
  mission.corners += 1;
  EXPECT_NE(at(one_shot(sid_status), 13, 4), crc32(values));
}

TEST_F(TelemetryTest, EveryReportIsFoundByItsNumberAndNoOther) {
  std::size_t found = 0;
  for (std::uint64_t id = 0; id < 300; ++id) {
    const ReportInfo* const report = find_report(id);
    if (report == nullptr) continue;
    ++found;
    EXPECT_EQ(report->id, id);
    EXPECT_LT(id, report_id_limit);
  }
  EXPECT_EQ(found, report_count);
}

TEST_F(TelemetryTest, CountersOfTheLinkHaveTheirLayout) {
  delivery.pdus_in = 0x01020304;
  delivery.cancelled = 9;
  link.up.push_back({1, 2, 3});
  const Bytes data = one_shot(sid_link);
  ASSERT_EQ(data.size(), 1U + 16 * 4);
  EXPECT_EQ(at(data, 1, 4), router->counts().received);
  EXPECT_EQ(at(data, 9, 4), 1U) << "malformed";
  EXPECT_EQ(at(data, 1 + 9 * 4, 4), 0x01020304U);
  EXPECT_EQ(at(data, 1 + 15 * 4, 4), 9U);
}

TEST_F(TelemetryTest, RealsAndArraysStandInTableOrder) {
  PoseRecord pose{.id = 4, .strip_id = 2, .state = PoseState::final};
  pose.q_cam_from_world[0] = 0.5;
  pose.q_cam_from_world[3] = -0.25;
  pose.centre[2] = 1000.125;
  write(pose);
  const Bytes data = one_shot(sid_pose);
  EXPECT_EQ(at(data, 1, 8), 4U);
  EXPECT_EQ(at(data, 9, 8), 2U);
  EXPECT_EQ(at(data, 17, 1), 1U);
  EXPECT_EQ(real_at(data, 24), 0.5);
  EXPECT_EQ(real_at(data, 24 + 3 * 8), -0.25);
  EXPECT_EQ(real_at(data, 24 + 4 * 8 + 2 * 8), 1000.125);
}

TEST_F(TelemetryTest, EveryReportFitsAPacketAndAllCanBeAskedForAtOnce) {
  Bytes list = {0, report_count};
  for (const ReportInfo& report : report_table()) {
    EXPECT_EQ(report.id, &report - report_table().data() + 1);
    list.push_back(report.id);
  }
  send(3, 27, list);
  run_frame();
  const auto reports = housekeeping_received();
  ASSERT_EQ(reports.size(), report_count);
  std::size_t i = 0;
  for (const Report& report : last_report) {
    if (report.service != 3) continue;
    EXPECT_EQ(report.data[0], i + 1);
    EXPECT_EQ(report.data.size(), 1 + report_bytes(report_table()[i])) << report_table()[i].name;
    ++i;
  }
}

TEST_F(TelemetryTest, HealthOfEveryComponentIsThere) {
  const Bytes data = one_shot(sid_components);
  ASSERT_EQ(data.size(), 1 + component_numbers * 32);
  for (std::size_t i = 0; i < component_numbers; ++i) {
    EXPECT_EQ(at(data, 1 + i * 32, 4), 100 + i) << "steps";
    EXPECT_EQ(at(data, 1 + i * 32 + 8, 4), 7U) << "restarts";
    EXPECT_EQ(at(data, 1 + i * 32 + 24, 8), 5'000'000U) << "longest step";
  }
  const Bytes status = one_shot(sid_status);
  EXPECT_EQ(at(status, 17, 4), 1234U) << "frames";
  EXPECT_EQ(at(status, 21, 4), 3U) << "late frames";
}

TEST_F(TelemetryTest, HealthOfAComponentInAnotherProcessIsThatOfItsRecord) {
  health.elsewhere = ComponentId::compressor;
  constexpr std::size_t place = static_cast<std::size_t>(ComponentId::compressor) - 1;
  ComponentRecord record{.id = static_cast<std::int64_t>(place) + 1, .steps = 5};
  write(record);
  const Bytes data = one_shot(sid_components);
  EXPECT_EQ(at(data, 1 + place * 32, 4), 5U);
  EXPECT_EQ(at(data, 1 + (place - 1) * 32, 4), 100 + place - 1);
}

TEST_F(TelemetryTest, TheProcessesThatShareTheFlightAreReported) {
  clock.set(7 * ns_per_s);
  NodeRecord node{.id = 1, .stages = 7, .seen_ns = 6 * ns_per_s};
  write(node);
  node.id = 9;
  node.stages = 256;
  node.connections = 3;
  write(node);
  const Bytes data = one_shot(sid_nodes);
  constexpr std::size_t one = 36;
  ASSERT_EQ(data.size(), 1 + most_nodes * one);
  EXPECT_EQ(at(data, 1, 4), 7U);
  EXPECT_EQ(at(data, 1 + 12, 8), 1'000'000'000U) << "silence";
  EXPECT_EQ(at(data, 1 + one, 4), 256U);
  EXPECT_EQ(at(data, 1 + one + 20, 4), 3U) << "connections";
  EXPECT_EQ(at(data, 1 + 2 * one, 4), 0U) << "there is no third one";
}

TEST_F(TelemetryTest, EventsAreToldBySeverity) {
  clock.set(61 * ns_per_ms);
  const StatusCode codes[] = {StatusCode::link_restored, StatusCode::overlap_unknown, StatusCode::frame_gap,
                              StatusCode::assertion_failed};
  for (const StatusCode code : codes) raise(code, 258, -2);
  clock.set(90 * ns_per_ms);
  run_frame();
  const std::vector<Report> reports = received();
  ASSERT_EQ(reports.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    const Bytes& data = reports[i].data;
    EXPECT_EQ(reports[i].service, 5);
    EXPECT_EQ(reports[i].subtype, static_cast<int>(i) + 1);
    EXPECT_EQ(reports[i].destination, 0);
    EXPECT_EQ(at(data, 0, 2), static_cast<std::uint64_t>(codes[i]));
    EXPECT_EQ(at(data, 2, 1), static_cast<std::uint64_t>(ComponentId::acquisition));
    EXPECT_EQ(at(data, 3, 8), 258U);
    EXPECT_EQ(at(data, 11, 8), 0xFFFFFFFFFFFFFFFEU);
    EXPECT_EQ(at(data, 19, 4), i + 1);
    EXPECT_EQ(at(data, 23, 1), 0x40U);
    // 2026-01-01 is day 24837 since 1958.
    EXPECT_EQ(at(data, 24, 2), 24837U);
    EXPECT_EQ(at(data, 26, 4), 61U);
  }
}

TEST_F(TelemetryTest, ADamagedEventKeepsNobodyFromTheNextOnes) {
  raise(StatusCode::frame_gap, 1);
  raise(StatusCode::frame_gap, 2);
  raise(StatusCode::frame_gap, 3);
  failing.damage(RecordType::event, 2);
  run_frame();
  const std::vector<Report> reports = received();
  ASSERT_EQ(reports.size(), 2U);
  EXPECT_EQ(at(reports[0].data, 3, 8), 1U);
  EXPECT_EQ(at(reports[1].data, 3, 8), 3U);
}

TEST_F(TelemetryTest, DisabledEventsAreNotTold) {
  const auto gap = static_cast<std::uint8_t>(StatusCode::frame_gap);
  const auto broken = static_cast<std::uint8_t>(StatusCode::strip_broken);
  send(5, 6, {0, 2, 0, gap, 0, broken}, 7);
  send(5, 7, {}, 7);
  run_frame();
  run_frame();
  EXPECT_EQ(types(), "1.1 1.3 1.7 1.1 1.3 5.8 1.7");
  EXPECT_EQ(last_report[5].destination, 7);
  EXPECT_EQ(last_report[5].data, gap < broken ? Bytes({0, 2, 0, gap, 0, broken}) : Bytes({0, 2, 0, broken, 0, gap}));
  raise(StatusCode::frame_gap);
  raise(StatusCode::strip_broken);
  raise(StatusCode::frame_late);
  run_frame();
  EXPECT_EQ(types(), "5.2");
  EXPECT_EQ(types_after(5, 5, {0, 1, 0, gap}), "1.1 1.3 1.7");
  raise(StatusCode::frame_gap);
  run_frame();
  EXPECT_EQ(types(), "5.3") << "from now on, not what came before";
  EXPECT_EQ(failure_after(5, 6, {0, 2, 0, gap, 0x7F, 0xFF}), "1.4 event_unknown");
  raise(StatusCode::frame_gap);
  run_frame();
  EXPECT_EQ(types(), "5.3") << "nothing of the list was done";
}

TEST_F(TelemetryTest, OutOfContactEventsWaitInTheStoreAndHousekeepingIsNotStacked) {
  send(3, 5, {0, 1, sid_status});
  send(3, 31, {0, 1, sid_status, 0, 0, 0, 100});
  run_frame();
  received();
  link.deaf = true;
  // Of ten codes, because each has a limit in time (EventLog).
  constexpr StatusCode codes[] = {StatusCode::frame_gap,        StatusCode::frame_overrun, StatusCode::camera_silent,
                                  StatusCode::camera_fault,     StatusCode::camera_absent, StatusCode::camera_recovered,
                                  StatusCode::camera_incapable, StatusCode::camera_size,   StatusCode::camera_graded,
                                  StatusCode::camera_distrusted};
  for (int i = 0; i < 500; ++i) raise(codes[i % 10], i);
  run_until(clock.now() + 60 * ns_per_s);
  EXPECT_LE(writer->waiting(), 20U);
  EXPECT_EQ(writer->lost(), 0U);
  link.deaf = false;
  run_until(clock.now() + 10 * ns_per_s);
  std::vector<std::int64_t> reported;
  int reports = 0;
  for (const Report& report : received()) {
    if (report.service == 5) reported.push_back(static_cast<std::int64_t>(at(report.data, 3, 8)));
    if (report.service == 3) ++reports;
  }
  ASSERT_EQ(reported.size(), 500U);
  for (std::size_t i = 0; i < reported.size(); ++i) EXPECT_EQ(reported[i], static_cast<std::int64_t>(i));
  EXPECT_GT(reports, 50);
  EXPECT_LT(reports, 110);
}

TEST_F(TelemetryTest, WidthsFollowTheTailoring) {
  mission.tailoring = GroundSystem::fsfw;
  writer->configure();
  send(3, 27, {0, 0, 0, 0, 0, 0, 0, sid_storage});
  send(5, 6);
  raise(StatusCode::frame_gap);
  run_frame();
  run_frame();
  EXPECT_EQ(types(), "1.1 1.3 1.1 1.3 1.7 3.25 1.7");
  EXPECT_EQ(at(last_report[5].data, 0, 8), sid_storage);
  send(5, 5);
  run_frame();
  raise(StatusCode::frame_gap, std::int64_t{1} << 40U, -3);
  run_frame();
  EXPECT_EQ(types(), "1.1 1.3 1.7 5.3");
  const Bytes data = last_report[3].data;
  EXPECT_EQ(at(data, 0, 2), static_cast<std::uint64_t>(StatusCode::frame_gap));
  EXPECT_EQ(at(data, 2, 4), static_cast<std::uint64_t>(ComponentId::acquisition)) << "reporter";
  EXPECT_EQ(at(data, 6, 4), 0x7FFFFFFFU) << "as near as it comes";
  EXPECT_EQ(at(data, 10, 4), 0xFFFFFFFDU);
}

TEST_F(TelemetryTest, TelecommandsOfIndependentSoftwareAreUnderstood) {
  const auto vectors = golden_vectors("tc.hex");
  if (vectors.empty()) GTEST_SKIP() << "no vectors";
  int performed = 0;
  for (const auto& [name, octets] : vectors) {
    if (octets.size() < 9 || (octets[7] != 3 && octets[7] != 5)) continue;
    link.up.push_back(octets);
    run_frame();
    bool accepted = false;
    for (const Report& report : received()) accepted |= report.service == 1 && report.subtype == 1;
    // New structures cannot be defined.
    EXPECT_EQ(accepted, name != "tc_3_1") << name;
    performed += accepted ? 1 : 0;
  }
  EXPECT_GE(performed, 6);
}

TEST_F(TelemetryTest, TheTableOfMessagesIsWhatIsTaken) {
  std::set<std::pair<int, int>> listed;
  for (const MessageInfo& info : message_table()) {
    if (info.telecommand) listed.emplace(info.service, info.subtype);
  }
  std::set<std::pair<int, int>> taken;
  for (int service = 0; service < 256; ++service) {
    for (int subtype = 0; subtype < 256; ++subtype) {
      clock.set(clock.now() + frame);
      send(service, subtype);
      telecommander->step();
      EXPECT_TRUE(telemetry->step().status.ok());
      const std::string said = failure();
      if (said != "1.2 service_unknown" && said != "1.2 subtype_unknown") taken.emplace(service, subtype);
    }
  }
  EXPECT_EQ(listed, taken);
}

TEST_F(TelemetryTest, TheTableOfMessagesHasWhatComesDown) {
  std::set<std::pair<int, int>> listed;
  for (const MessageInfo& info : message_table()) {
    if (!info.telecommand) listed.emplace(info.service, info.subtype);
  }
  for (const auto& [name, octets] : golden_vectors("tc.hex")) {
    link.up.push_back(octets);
    raise(StatusCode::frame_gap);
    run_frame();
    for (const Report& report : received()) {
      EXPECT_TRUE(listed.contains({report.service, report.subtype})) << report.service << "," << report.subtype;
    }
  }
}

TEST_F(TelemetryTest, HousekeepingAndEventsGoOnWhileTheStoreIsLocked) {
  send(3, 5, {0, 2, sid_status, sid_storage});
  run_frame();
  run_frame();
  raise(StatusCode::frame_gap);
  received();
  failing.lock();
  std::size_t reports = 0, events = 0;
  for (const TimeNs end = clock.now() + 30 * ns_per_s; clock.now() < end; clock.set(clock.now() + frame)) {
    telecommander->step();
    static_cast<void>(telemetry->step());
    for (const Report& report : received()) {
      reports += report.service == 3 ? 1 : 0;
      events += report.service == 5 ? 1 : 0;
    }
  }
  EXPECT_EQ(reports, 4U) << "two every ten seconds";
  EXPECT_EQ(events, 1U) << "once";
}

}  // namespace
}  // namespace ilp::test
