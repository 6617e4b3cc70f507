// Requests whose completion is found in the records of other components.
#include <gtest/gtest.h>

#include <limits>

#include "tests/unit/commanding/telecommand_fixture.hpp"

namespace ilp::test {
namespace {

// The server of a store may refuse a table for a while, which says nothing about what is in it.
TEST_F(TelecommandTest, WhatCannotBeReadAtThisTimeIsNotGone) {
  send(8, 1, function("CAPTURE"));
  step();
  answer_capture(last_command(), CaptureState::pending);
  step();
  types();
  failing.judge_by([](const FailingStore::Call& call) {
    const bool refused = call.kind == StoreCall::get && call.type == RecordType::capture;
    return refused ? Status{StatusCode::store_denied, static_cast<std::int64_t>(RecordType::capture)} : Status{};
  });
  EXPECT_TRUE(telecommander->step().status.is(StatusCode::store_denied));
  EXPECT_EQ(types(), "") << "the request stays open";
  failing.judge_by({});
  CaptureRecord capture = read<CaptureRecord>(1);
  capture.state = CaptureState::exposed;
  write(capture);
  step();
  EXPECT_EQ(types(), "1.7");
}

Bytes place(double longitude, double latitude, double distance, std::uint32_t limit_s) {
  Bytes octets(28);
  ByteWriter out(octets);
  for (const double value : {longitude, latitude, distance}) out.f64(value);
  out.u32(limit_s);
  return octets;
}

TEST_F(TelecommandTest, AnImageAtAPlaceCompletesWhenItIsExposed) {
  mission.body = Body::mars;
  mission.use_navigation = true;
  clock.set(5 * ns_per_s);
  EXPECT_EQ(types_after(8, 1, function("CAPTPLAC", place(137.4, -4.5, 25, 3600))), "1.1 1.3");
  const CommandRecord command = last_command();
  EXPECT_EQ(command.kind, CommandKind::capture_place);
  EXPECT_EQ(command.longitude_deg, 137.4);
  EXPECT_EQ(command.latitude_deg, -4.5);
  EXPECT_EQ(command.distance_m, 25);
  EXPECT_EQ(command.at_ns, 3605 * ns_per_s);
  step_at(3000 * ns_per_s);
  expect_completion_with_exposure(command);
}

TEST_F(TelecommandTest, APlaceThatWasMissedFailsWithItsNearestApproach) {
  mission.body = Body::titan;
  mission.use_map = true;
  EXPECT_EQ(types_after(8, 1, function("CAPTPLAC", place(-12, 70, 25, 0))), "1.1 1.3");
  EXPECT_EQ(last_command().at_ns, 0) << "until the flight ends";
  step_at(40'000'000 * ns_per_s);
  EXPECT_EQ(types(), "") << "for more than a year";
  CaptureRecord capture;
  capture.id = 1;
  capture.command_id = last_command().id;
  capture.state = CaptureState::rejected;
  capture.reason = static_cast<std::uint16_t>(StatusCode::place_missed);
  capture.distance_m = 431;
  write(capture);
  step();
  EXPECT_EQ(failure(), "1.8 place_missed");
  EXPECT_EQ(value_of(last_report[0], 0), capture.command_id);
  EXPECT_EQ(value_of(last_report[0], 1), 431);
}

TEST_F(TelecommandTest, APlaceIsRefusedWhereItCannotBeReached) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
  mission.use_navigation = true;
  EXPECT_EQ(failure_after(8, 1, function("CAPTPLAC", place(137.4, -4.5, 25, 0))), "1.4 places_unknown")
      << "over no body";
  mission.body = Body::mars;
  mission.use_navigation = false;
  EXPECT_EQ(failure_after(8, 1, function("CAPTPLAC", place(137.4, -4.5, 25, 0))), "1.4 places_unknown")
      << "neither measurements nor a map";
  mission.use_navigation = true;
  for (const Bytes& arguments : {place(nan, 0, 25, 0), place(361, 0, 25, 0), place(0, infinite, 25, 0),
                                 place(0, -90.1, 25, 0), place(0, 0, nan, 0), place(0, 0, 0, 0), place(0, 0, -1, 0),
                                 place(0, 0, 1.1e5, 0), place(0, 0, 25, 3000000001)}) {
    EXPECT_EQ(failure_after(8, 1, function("CAPTPLAC", arguments)), "1.4 invalid_argument");
  }
  EXPECT_EQ(failure_after(8, 1, function("CAPTPLAC", numbers({{1, 4}}))), "1.4 function_arguments");
  EXPECT_EQ(number_of<CommandRecord>(), 0);
}

}  // namespace
}  // namespace ilp::test
