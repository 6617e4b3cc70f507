// Requests whose completion is found in the records of other components.
#include <gtest/gtest.h>

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

}  // namespace
}  // namespace ilp::test
