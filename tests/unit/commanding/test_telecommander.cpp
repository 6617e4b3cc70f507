// Verification, test, functions and parameters as a ground station sees them.
#include <gtest/gtest.h>

#include "fsw/base/text.hpp"
#include "fsw/commanding/settings.hpp"
#include "fsw/packets/pass_schedule.hpp"
#include "tests/unit/commanding/telecommand_fixture.hpp"

namespace ilp::test {
namespace {

TEST_F(TelecommandTest, PingIsAnsweredInOrder) {
  const std::uint16_t ping = send(17, 1);
  step();
  EXPECT_EQ(types(), "1.1 1.3 17.2 1.7");
  for (const Report& report : last_report) {
    EXPECT_EQ(report.destination, 1);
    EXPECT_TRUE(report.service == 17 || request_of(report) == request_of(ping));
  }
  EXPECT_EQ(last_report[3].sequence, 3);
}

TEST_F(TelecommandTest, FlagsChooseTheReportsOfSuccess) {
  EXPECT_EQ(types_after(17, 1, {}, 1, 0), "17.2");
  EXPECT_EQ(types_after(17, 1, {}, 1, ack::acceptance), "1.1 17.2");
  EXPECT_EQ(types_after(17, 1, {}, 1, ack::completion), "17.2 1.7");
  EXPECT_EQ(failure_after(77, 1, {}, 1, 0), "1.2 service_unknown");
}

TEST_F(TelecommandTest, ConnectionIsToThisApplicationOnly) {
  EXPECT_EQ(types_after(17, 3, {0x00, 0xEF}), "1.1 1.3 17.4 1.7");
  EXPECT_EQ(last_report[2].data, (Bytes{0x00, 0xEF}));
  EXPECT_EQ(failure_after(17, 3, {0x00, 0xEE}), "1.4 packet_apid");
  EXPECT_EQ(failure_after(17, 3, {0x00}), "1.2 request_malformed");
}

TEST_F(TelecommandTest, WhatIsUnknownIsAnswered) {
  const std::pair<int, int> unknown[] = {{17, 99}, {8, 2}, {11, 99}, {20, 4}};
  for (const auto& [service, subtype] : unknown) {
    EXPECT_EQ(failure_after(service, subtype), "1.2 subtype_unknown") << service;
    EXPECT_EQ(value_of(last_report[0], 0), service);
    EXPECT_EQ(value_of(last_report[0], 1), subtype);
  }
  EXPECT_EQ(failure_after(8, 1, function("NOSUCH")), "1.4 function_unknown");
}

TEST_F(TelecommandTest, MalformedPacketsAreAnsweredWithTheirReason) {
  Bytes bad = packet(17, 1);
  bad.back() ^= 1;
  link.up.push_back(bad);
  step();
  EXPECT_EQ(failure(), "1.2 packet_crc");
  EXPECT_EQ(last_report[0].destination, 1);
  Bytes telemetry = packet(17, 1);
  telemetry[0] &= 0xEF;
  link.up.push_back(telemetry);
  step();
  EXPECT_EQ(types(), "");
  // And the package goes on.
  EXPECT_EQ(types_after(17, 1), "1.1 1.3 17.2 1.7");
}

TEST_F(TelecommandTest, EverySingleDamageLeavesItAlive) {
  const Bytes good = packet(20, 1, numbers({{1, 2}, {1, 2}}));
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    Bytes damaged = good;
    damaged[bit / 8] = static_cast<std::uint8_t>(damaged[bit / 8] ^ (0x80U >> bit % 8));
    link.up.push_back(damaged);
    clock.set(clock.now() + minor_frame_ns);
    step();
    for (const Report& report : received()) EXPECT_TRUE(report == std::make_pair(1, 2)) << "bit " << bit;
  }
  EXPECT_EQ(types_after(17, 1), "1.1 1.3 17.2 1.7");
}

TEST_F(TelecommandTest, TwoGroundStationsHearTheirOwnReportsAndCounts) {
  for (int i = 0; i < 3; ++i) {
    send(17, 1, {}, 7);
    send(17, 1, {}, 9);
  }
  step();
  int seen[2] = {};
  std::uint16_t sequence = 0;
  for (const Report& report : received()) {
    EXPECT_EQ(report.sequence, sequence++);
    if (report.service != 17) continue;
    const int station = report.destination == 7 ? 0 : 1;
    EXPECT_EQ(report.counter, seen[station]++);
  }
  EXPECT_EQ(seen[0], 3);
  EXPECT_EQ(seen[1], 3);
}

TEST_F(TelecommandTest, CountsOfReportsGoOnBehindTheirEnds) {
  // The count of packets has 14 bits, that of messages of one kind 16.
  for (std::uint32_t i = 0; i < 70'000; ++i) {
    ASSERT_TRUE(writer->report(17, 2, 7, {}).ok());
    const std::vector<Report> reports = received();
    ASSERT_EQ(reports.size(), 1U) << i;
    ASSERT_EQ(reports[0].sequence, i % 16'384U);
    ASSERT_EQ(reports[0].counter, i % 65'536U);
    // The budget of the link.
    clock.set(clock.now() + ns_per_ms);
  }
  EXPECT_EQ(writer->lost(), 0U);
}

TEST_F(TelecommandTest, ReportsWaitForContactAndTheOldestAreLost) {
  link.deaf = true;
  send(17, 1);
  step();
  EXPECT_EQ(writer->waiting(), 4U);
  link.deaf = false;
  step();
  EXPECT_EQ(types(), "1.1 1.3 17.2 1.7");
  link.deaf = true;
  const std::uint32_t enough = static_cast<std::uint32_t>(limits::telemetry_ring_bytes / 21);
  for (std::uint32_t i = 0; i < enough; ++i) {
    send(17, 1);
    if (i % 16 == 0) clock.set(clock.now() + minor_frame_ns), step();
  }
  EXPECT_GT(writer->lost(), 0U);
  link.deaf = false;
  Status reported;
  for (int i = 0; i < 100 && reported.ok(); ++i) {
    clock.set(clock.now() + minor_frame_ns);
    reported = telecommander->step().status;
  }
  EXPECT_TRUE(reported.is(StatusCode::telemetry_lost));
  EXPECT_EQ(reported.a, writer->lost());
  EXPECT_EQ(received().back().service, 1);
}

TEST_F(TelecommandTest, AFloodIsBoundedPerStepAndAnswered) {
  for (int i = 0; i < 100; ++i) send(17, 1, {}, 1, 0);
  EXPECT_TRUE(telecommander->step().status.ok());
  EXPECT_EQ(received().size(), 32U);
  for (int i = 0; i < 5; ++i) clock.set(clock.now() + minor_frame_ns), step();
  EXPECT_EQ(received().size(), 68U);
}

TEST_F(TelecommandTest, CaptureCompletesWhenTheImageIsExposed) {
  clock.set(5 * ns_per_s);
  EXPECT_EQ(types_after(8, 1, function("CAPTURE", {0x00, 0x50})), "1.1 1.3");
  const CommandRecord command = last_command();
  EXPECT_EQ(command.kind, CommandKind::capture_soon);
  EXPECT_EQ(command.at_ns, 5 * ns_per_s);
  EXPECT_EQ(command.tag, 80);
  expect_completion_with_exposure(command);
}

TEST_F(TelecommandTest, ADamagedCaptureOrCommandKeepsNobodyFromTheNextOnes) {
  CaptureRecord damaged{.id = 1};
  write(damaged);
  failing.damage(RecordType::capture, 1);
  CaptureRecord orphan{.id = 2, .command_id = 1};
  write(orphan);
  failing.damage(RecordType::command, 1);
  EXPECT_EQ(types_after(8, 1, function("CAPTURE")), "1.1 1.3");
  CaptureRecord capture{.id = 3, .command_id = last_command().id};
  write(capture);
  step();
  capture.state = CaptureState::exposed;
  write(capture);
  step();
  EXPECT_EQ(types(), "1.7");
}

TEST_F(TelecommandTest, WhatARequestWaitsForMayBeDamagedAndOthersAreCompleted) {
  StripRecord strip{.id = 1};
  write(strip);
  ProductRecord product{.id = product_id(1, ProductKind::image), .keyframe_id = 1, .kind = ProductKind::image};
  write(product);
  send(8, 1, function("STRIPEND"));
  send(8, 1, function("FLUSH"));
  send(8, 1, function("STRIPBEG"));
  EXPECT_EQ(types_after(8, 1, function("PRODDEL", numbers({{1, 4}, {1, 1}}))), "1.1 1.3 1.1 1.3 1.1 1.3 1.1 1.3");
  let_overlap_checker_obey(last_command().id);
  failing.damage(RecordType::strip, 1);
  failing.damage(RecordType::product, product.id);
  step();
  EXPECT_EQ(types(), "1.7") << "the strip's end alone";
  send(8, 1, function("CAPTURE"));
  step();
  answer_capture(last_command(), CaptureState::pending);
  step();
  types();
  failing.damage(RecordType::capture, 1);
  step();
  EXPECT_EQ(failure(), "1.8 no_completion") << "of the capture";
  send(8, 1, function("CAPTURE"));
  step();
  types();
  answer_capture(last_command(), CaptureState::exposed);
  step();
  EXPECT_EQ(types(), "1.7") << "though the strip of the first request cannot be read";
}

TEST_F(TelecommandTest, ACaptureThatFailsTellsWhy) {
  const std::pair<CaptureState, const char*> cases[] = {{CaptureState::no_frame, "1.8 capture_missed"},
                                                        {CaptureState::rejected, "1.8 capture_too_soon"},
                                                        {CaptureState::superseded, "1.8 capture_superseded"}};
  for (const auto& [state, expected] : cases) {
    send(8, 1, function("CAPTURE"));
    step();
    received();
    const bool rejected = state == CaptureState::rejected;
    answer_capture(last_command(), state, rejected ? StatusCode::capture_too_soon : StatusCode::ok);
    step();
    EXPECT_EQ(failure(), expected);
    if (state == CaptureState::no_frame) {
      EXPECT_EQ(value_of(last_report.back(), 1), 3000) << "ms, as the event says";
    }
  }
  // Nothing ever comes of it.
  send(8, 1, function("CAPTURE"));
  step();
  step_at(clock.now() + 70 * ns_per_s);
  EXPECT_EQ(failure(), "1.8 no_completion");
}

TEST_F(TelecommandTest, CaptureAtATime) {
  clock.set(100 * ns_per_s);
  EXPECT_EQ(types_after(8, 1, function("CAPTAT", time_of(104 * ns_per_s + 250 * ns_per_ms))), "1.1 1.3");
  EXPECT_EQ(last_command().kind, CommandKind::capture);
  EXPECT_EQ(last_command().at_ns, 104 * ns_per_s + 250 * ns_per_ms);
  EXPECT_EQ(failure_after(8, 1, function("CAPTAT", time_of(99 * ns_per_s))), "1.4 release_in_past");
  EXPECT_EQ(value_of(last_report.back(), 0), 1000);
  EXPECT_EQ(failure_after(8, 1, function("CAPTAT", {0x40, 0x61})), "1.4 function_arguments");
  EXPECT_EQ(failure_after(8, 1, function("CAPTAT", {0x77, 0x61, 0x05, 0, 0, 0, 0})), "1.4 time_code_unknown");
}

TEST_F(TelecommandTest, ASeriesReportsEveryImageAndItsEnd) {
  mission.capture_min_interval_s = 0.1;
  const auto arguments = [&](TimeNs first, std::uint32_t ms, std::uint16_t number) {
    return time_of(first) + numbers({{ms, 4}, {number, 2}});
  };
  EXPECT_EQ(types_after(8, 1, function("CAPTSER", arguments(10 * ns_per_s, 1000, 5))), "1.1 1.3");
  EXPECT_EQ(number_of<CommandRecord>(), 0);  // far ahead of its time nothing is commanded
  std::string all;
  std::int64_t answered = 0;
  StatusCode reason = StatusCode::ok;
  for (TimeNs now = 8 * ns_per_s; now < 20 * ns_per_s; now += 500 * ns_per_ms) {
    step_at(now);
    while (answered < number_of<CommandRecord>()) {
      const CommandRecord command = read<CommandRecord>(++answered);
      EXPECT_EQ(command.at_ns, (9 + answered) * ns_per_s);
      answer_capture(command, answered == 3 ? CaptureState::no_frame : CaptureState::exposed);
    }
    if (const std::string more = types(); !more.empty()) all += (all.empty() ? "" : " ") + more;
    for (const Report& report : last_report) reason = report.subtype == 8 ? code_of(report) : reason;
  }
  EXPECT_EQ(all, "1.5 1.5 1.5 1.5 1.8");
  EXPECT_EQ(reason, StatusCode::capture_missed);
  send(8, 1, function("CAPTSER", arguments(100 * ns_per_s, 10, 5)));
  EXPECT_EQ(failure_after(8, 1, function("CAPTSER", arguments(100 * ns_per_s, 1000, 0))),
            "1.4 invalid_argument 1.4 invalid_argument");
}

TEST_F(TelecommandTest, OpenRequestsSurviveARestart) {
  const std::uint16_t sequence = send(8, 1, function("CAPTURE"), 5);
  step();
  received();
  answer_capture(last_command(), CaptureState::pending);
  step();
  begin();
  CaptureRecord capture = read<CaptureRecord>(1);
  capture.state = CaptureState::exposed;
  write(capture);
  step();
  EXPECT_EQ(types(), "1.7");
  EXPECT_EQ(request_of(last_report[0]), request_of(sequence));
  EXPECT_EQ(last_report[0].destination, 5);
  step();
  EXPECT_EQ(types(), "");
}

TEST_F(TelecommandTest, ALongPastDelaysNoReport) {
  for (std::int64_t id = 1; id <= 500; ++id) {
    CaptureRecord capture{.id = id, .state = CaptureState::exposed};
    write(capture);
  }
  begin();
  send(8, 1, function("CAPTURE"));
  step();
  received();
  answer_capture(last_command(), CaptureState::exposed);
  EXPECT_TRUE(telecommander->step().status.ok());
  EXPECT_EQ(types(), "1.7");
}

TEST_F(TelecommandTest, ParametersAreReportedWithTheirTypes) {
  mission.corners = 700;
  begin();
  const std::uint16_t corners = id_of("motion", "corners"), overlap = id_of("overlap", "target_overlap");
  EXPECT_EQ(types_after(20, 1, numbers({{2, 2}, {corners, 2}, {overlap, 2}})), "1.1 1.3 20.2 1.7");
  Bytes expected = numbers({{2, 2}, {corners, 2}, {700, 2}, {overlap, 2}, {std::bit_cast<std::uint64_t>(0.82), 8}});
  EXPECT_EQ(last_report[2].data, expected);
}

TEST_F(TelecommandTest, ParametersAreSetAndStaySet) {
  const std::uint16_t corners = id_of("motion", "corners"), overlap = id_of("overlap", "target_overlap");
  EXPECT_EQ(
      types_after(20, 3,
                  numbers({{2, 2}, {corners, 2}, {555, 2}, {overlap, 2}, {std::bit_cast<std::uint64_t>(0.75), 8}})),
      "1.1 1.3 1.7");
  EXPECT_EQ(mission.corners, 555);
  EXPECT_EQ(mission.target_overlap, 0.75);
  MissionParameters later;
  later.corners = 900;
  ASSERT_TRUE(load_settings(store, later).ok());
  EXPECT_EQ(later.corners, 555);
  EXPECT_EQ(later.target_overlap, 0.75);
}

TEST_F(TelecommandTest, OneBadParameterSetsNone) {
  const std::uint16_t corners = id_of("motion", "corners"), overlap = id_of("overlap", "target_overlap");
  const std::uint16_t least = id_of("overlap", "min_overlap");
  const double before = mission.corners;
  const auto set = [&](const Bytes& data) {
    send(20, 3, data);
    step();
    EXPECT_EQ(mission.corners, before);
    EXPECT_EQ(number_of<SettingRecord>(), 0);
    return failure();
  };
  EXPECT_EQ(set(numbers({{2, 2}, {corners, 2}, {555, 2}, {0xEEEE, 2}, {1, 2}})), "1.4 parameter_unknown");
  EXPECT_EQ(value_of(last_report.back(), 0), 0xEEEE);
  EXPECT_EQ(value_of(last_report.back(), 1), 1);
  EXPECT_EQ(set(numbers({{2, 2}, {corners, 2}, {555, 2}, {corners, 2}, {65535, 2}})), "1.4 parameter_out_of_range");
  EXPECT_EQ(set(numbers({{1, 2}, {0, 2}, {1, 2}})), "1.4 parameter_unknown");
  const std::uint64_t nan = 0x7FF8000000000000;
  EXPECT_EQ(set(numbers({{1, 2}, {overlap, 2}, {nan, 8}})), "1.4 parameter_out_of_range");
  EXPECT_EQ(set(numbers({{1, 2}, {least, 2}, {std::bit_cast<std::uint64_t>(0.9), 8}})), "1.4 parameters_contradict");
  EXPECT_EQ(set(numbers({{0, 2}})), "1.2 request_malformed");
  EXPECT_EQ(set(numbers({{0, 2}, {0x01020304, 4}})), "1.2 request_malformed");
  EXPECT_EQ(set(numbers({{1, 2}, {corners, 2}, {5, 1}})), "1.2 request_malformed");
  EXPECT_EQ(set(numbers({{1, 2}, {corners, 2}, {555, 2}, {0, 1}})), "1.2 request_malformed");
  EXPECT_EQ(set(numbers({{1000, 2}})), "1.2 capacity_exceeded");
  EXPECT_EQ(failure_after(20, 1, numbers({{1, 2}, {0xEEEE, 2}})), "1.4 parameter_unknown");
}

TEST_F(TelecommandTest, WhatWaitsForTheNextStartIsReportedButDoesNotAct) {
  const std::uint16_t id = id_of("link", "apid");
  send(20, 3, numbers({{1, 2}, {id, 2}, {300, 2}}));
  send(20, 1, numbers({{1, 2}, {id, 2}}));
  step();
  EXPECT_EQ(mission.apid, 239);
  EXPECT_EQ(received()[5].data, numbers({{1, 2}, {id, 2}, {300, 2}}));
  MissionParameters later;
  ASSERT_TRUE(load_settings(store, later).ok());
  EXPECT_EQ(later.apid, 300);
}

TEST_F(TelecommandTest, ASettingThatDoesNotFitAnyMoreIsLeftOut) {
  SettingRecord setting{.id = id_of("motion", "corners"), .value = 1e9};
  write(setting);
  setting.id = 60000;  // of no parameter
  write(setting);
  setting.id = id_of("overlap", "target_overlap");
  setting.value = 0.7;
  write(setting);
  MissionParameters later;
  const Status status = load_settings(store, later);
  EXPECT_TRUE(status.is(StatusCode::setting_ignored));
  EXPECT_EQ(status.a, id_of("motion", "corners"));
  EXPECT_EQ(later.corners, 1000);
  EXPECT_EQ(later.target_overlap, 0.7);
}

TEST_F(TelecommandTest, ModesArePersistentParameters) {
  send(8, 1, function("CAPMODE", {1}));
  EXPECT_EQ(types_after(8, 1, function("SAFEMODE", {1})), "1.1 1.3 1.7 1.1 1.3 1.7");
  EXPECT_EQ(mission.capture_mode, CaptureMode::forecast);
  EXPECT_TRUE(mission.safe_mode);
  MissionParameters later;
  ASSERT_TRUE(load_settings(store, later).ok());
  EXPECT_EQ(later.capture_mode, CaptureMode::forecast);
  EXPECT_TRUE(later.safe_mode);
  EXPECT_EQ(failure_after(8, 1, function("CAPMODE", {3})), "1.4 parameter_out_of_range");
  EXPECT_EQ(failure_after(8, 1, function("CAPMODE")), "1.4 function_arguments");
}

TEST_F(TelecommandTest, PassesBeginAndEndByCommand) {
  clock.set(50 * ns_per_s);
  send(8, 1, function("PASSEND"));
  step();
  // The report goes out before the pass ends.
  EXPECT_EQ(types(), "1.1 1.3 1.7");
  EXPECT_FALSE(contact_at(mission, 51 * ns_per_s).open);
  EXPECT_TRUE(contact_at(mission, 51 * ns_per_s + continuous_window_ns).open);
  clock.set(200 * ns_per_s);
  EXPECT_EQ(types_after(8, 1, function("PASSBEG", {0, 0, 0, 60})), "1.1 1.3 1.7");
  EXPECT_EQ(mission.opened_until_s, 260);
  EXPECT_EQ(failure_after(8, 1, function("PASSBEG", {0, 0, 0, 0})), "1.4 invalid_argument");
}

// 10^9 s are 31.7 years, 2^31 s are 68 years, and 2^31 ms are 25 days.
TEST_F(TelecommandTest, PassesBeginAndEndByCommandUpToTheLatestMissionTime) {
  for (const double begin_s : {2'147'483.0, 0.99e9, 1.01e9, 2'147'483'600.0, 3.99e9}) {
    SCOPED_TRACE(begin_s);
    clock.set(ns_from_seconds(begin_s));
    EXPECT_EQ(types_after(8, 1, function("PASSEND")), "1.1 1.3 1.7");
    clock.set(clock.now() + ns_per_ms);
    EXPECT_FALSE(router->contact());
    clock.set(clock.now() + continuous_window_ns);
    EXPECT_TRUE(router->contact());
    EXPECT_EQ(types_after(8, 1, function("PASSBEG", {0, 0, 0, 60})), "1.1 1.3 1.7");
    EXPECT_NEAR(mission.opened_until_s, 1e-9 * static_cast<double>(clock.now()) + 60, 1e-3);
  }
}

TEST_F(TelecommandTest, StripsEndWhenTheOverlapCheckerHasObeyed) {
  FrameRecord frame{.id = 9};
  write(frame);
  StripRecord strip{.id = 1, .last_keyframe_id = 4};
  write(strip);
  send(8, 1, function("STRIPEND"));
  send(8, 1, function("FLUSH"));
  EXPECT_EQ(types_after(8, 1, function("STRIPBEG")), "1.1 1.3 1.1 1.3 1.1 1.3");
  const CommandRecord command = last_command();
  EXPECT_EQ(command.kind, CommandKind::end_strip);
  EXPECT_EQ(command.reason, StripEnd::commanded);
  EXPECT_EQ(command.after_frame_id, 9);
  strip.end = StripEnd::commanded;
  write(strip);
  let_overlap_checker_obey(command.id);
  step();
  EXPECT_EQ(types(), "1.7");  // the end; poses are not final, and no strip has begun
  PoseRecord pose{.id = 4, .state = PoseState::provisional};
  write(pose);
  step();
  EXPECT_EQ(types(), "");
  pose.state = PoseState::final;
  write(pose);
  step();
  EXPECT_EQ(types(), "1.7");
  strip.id = 2;
  strip.end = StripEnd::open;
  write(strip);
  step();
  EXPECT_EQ(types(), "1.7");
}

TEST_F(TelecommandTest, ProductsAreRefinedAndDeleted) {
  ProductRecord product{.id = product_id(7, ProductKind::image), .keyframe_id = 7};
  write(product);
  EXPECT_EQ(types_after(8, 1, function("REFINE", numbers({{7, 4}}))), "1.1 1.3 1.7");
  EXPECT_EQ(last_command().kind, CommandKind::refine);
  EXPECT_EQ(last_command().keyframe_id, 7);
  EXPECT_EQ(failure_after(8, 1, function("REFINE", numbers({{8, 4}}))), "1.4 not_found");
  EXPECT_EQ(types_after(8, 1, function("PRODDEL", numbers({{7, 4}, {1, 1}}))), "1.1 1.3");
  EXPECT_EQ(last_command().subject_id, product.id);
  product.state = ProductState::dropped;
  write(product);
  step();
  EXPECT_EQ(types(), "1.7");
  send(8, 1, function("PRODDEL", numbers({{7, 4}, {2, 1}})));
  EXPECT_EQ(failure_after(8, 1, function("PRODDEL", numbers({{99, 4}, {0, 1}}))), "1.4 invalid_argument 1.4 not_found");
}

TEST_F(TelecommandTest, ARestartIsReportedAsDoneHoweverManyEventsCameBefore) {
  EXPECT_EQ(types_after(8, 1, function("RESTART", {3})), "1.1 1.3");
  EventRecord event;
  for (event.id = 1; event.id <= 2000; ++event.id) {
    event.code = static_cast<std::uint16_t>(StatusCode::frame_gap);
    write(event);
  }
  event.code = static_cast<std::uint16_t>(StatusCode::component_restarted);
  event.a = 3;
  write(event);
  for (int i = 0; i < 3; ++i) step();
  // Also where it was looked for in the middle of a restart.
  begin();
  for (int i = 0; i < 3; ++i) step();
  EXPECT_EQ(types(), "1.7");
}

TEST_F(TelecommandTest, ARestartIsCompleteWhenItsEventIsThere) {
  EXPECT_EQ(types_after(8, 1, function("RESTART", {3})), "1.1 1.3");
  EXPECT_EQ(last_command().kind, CommandKind::restart);
  EXPECT_EQ(last_command().subject_id, 3);
  EventRecord event{.id = 1, .code = static_cast<std::uint16_t>(StatusCode::component_restarted), .a = 2};
  write(event);
  step();
  EXPECT_EQ(types(), "");
  event.id = 2;
  event.a = 3;
  write(event);
  step();
  EXPECT_EQ(types(), "1.7");
  send(8, 1, function("RESTART", {0}));
  EXPECT_EQ(failure_after(8, 1, function("RESTART", {200})), "1.4 invalid_argument 1.4 invalid_argument");
}

TEST_F(TelecommandTest, AnUplinkedFileTakesEffectAndTransfersTakeWishes) {
  const std::string content = "[overlap]\ntarget_overlap = 0.9\n";
  UplinkRecord uplink{.id = 4};
  uplink.data.bytes = static_cast<std::uint32_t>(content.size());
  write(uplink, "data", {reinterpret_cast<const std::uint8_t*>(content.data()), content.size()});
  TransferRecord transfer{.id = 9, .sequence = 31};
  write(transfer);
  send(8, 1, function("ACTIVATE", numbers({{4, 4}})));
  send(8, 1, function("XFERSUSP", numbers({{31, 4}})));
  step();
  EXPECT_EQ(mission.target_overlap, 0.9);
  EXPECT_EQ(number_of<SettingRecord>(), 1) << "kept for the next start";
  EXPECT_EQ(read<UplinkRecord>(4).state, UplinkState::active);
  EXPECT_EQ(read<TransferRecord>(9).wish, TransferWish::suspend);
  send(8, 1, function("ACTIVATE", numbers({{5, 4}})));
  EXPECT_EQ(failure_after(8, 1, function("XFERCANC", numbers({{32, 4}}))), "1.4 not_found 1.4 not_found");
}

TEST_F(TelecommandTest, OpenRequestsAreBounded) {
  for (std::size_t i = 0; i < limits::max_open_requests; ++i) {
    send(8, 1, function("CAPTURE"));
    if (i % 16 == 0) clock.set(clock.now() + minor_frame_ns), step();
  }
  step();
  EXPECT_EQ(failure(), "");
  const std::int64_t commands = number_of<CommandRecord>();
  EXPECT_EQ(failure_after(8, 1, function("CAPTURE")), "1.4 requests_full");
  EXPECT_EQ(number_of<CommandRecord>(), commands);
}

TEST_F(TelecommandTest, CountsAreKept) {
  send(17, 1);
  send(77, 1);
  send(8, 1, function("NOSUCH"));
  step();
  for (int i = 0; i < 60; ++i) EXPECT_TRUE(telecommander->step().status.ok());
  const auto counts = read<CommandingRecord>(1);
  EXPECT_EQ(counts.received, 3U);
  EXPECT_EQ(counts.accepted, 2U);
  EXPECT_EQ(counts.rejected, 1U);
  EXPECT_EQ(counts.completed, 1U);
  EXPECT_EQ(counts.failed, 1U);
  EXPECT_EQ(counts.reports_sent, 4U + 1U + 2U);
}

TEST_F(TelecommandTest, WhileTheStoreIsLockedWhatChangesNothingIsCarriedOut) {
  failing.lock();
  send(17, 1);
  EXPECT_TRUE(telecommander->step().status.ok());
  EXPECT_EQ(types(), "1.1 1.3 17.2 1.7") << "in the same minor frame";
  send(17, 3, {0x00, 0xEF});
  send(20, 1, numbers({{1, 2}, {1, 2}}));
  send(11, 17);
  EXPECT_EQ(types_after(11, 16), "1.1 1.3 17.4 1.7 1.1 1.3 20.2 1.7 1.1 1.3 11.13 1.7 1.1 1.3 11.10 1.7");
}

TEST_F(TelecommandTest, ATelecommandThatNeedsTheStoreWaitsForAShortLock) {
  failing.lock();
  send(8, 1, function("CAPTURE"));
  send(17, 1);
  for (int k = 0; k < 15; ++k) {
    EXPECT_TRUE(telecommander->step().status.ok());
    clock.set(clock.now() + minor_frame_ns);
  }
  EXPECT_EQ(types(), "") << "telecommands keep their order";
  failing.recover();
  step();
  EXPECT_EQ(types(), "1.1 1.3 1.1 1.3 17.2 1.7");
  EXPECT_EQ(last_command().kind, CommandKind::capture_soon);
}

TEST_F(TelecommandTest, ATelecommandThatNeedsTheStoreFailsWithTheCauseWhenTheLockLasts) {
  failing.lock();
  send(8, 1, function("CAPTURE"));
  for (int k = 0; k <= 20; ++k) {
    EXPECT_TRUE(telecommander->step().status.ok());
    clock.set(clock.now() + minor_frame_ns);
  }
  EXPECT_EQ(failure(), "1.4 store_locked");
  send(8, 1, function("FLUSH"));
  send(17, 1);
  EXPECT_TRUE(telecommander->step().status.ok());
  EXPECT_EQ(types(), "1.1 1.4 1.1 1.3 17.2 1.7") << "at once";
  failing.recover();
  step();
  EXPECT_EQ(number_of<CommandRecord>(), 0) << "what was reported as failed is not carried out later";
  send(8, 1, function("FLUSH"));
  step();
  EXPECT_EQ(last_command().kind, CommandKind::end_strip);
}

}  // namespace
}  // namespace ilp::test
