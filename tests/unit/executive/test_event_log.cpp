// The limit in time that every event has, and events that could not be stored.
#include <string>

#include "hal/store/newest_id.hpp"
#include "tests/unit/executive/executive_fixture.hpp"
#include "tests/unit/executive/refusing_store.hpp"

namespace ilp {
namespace {

constexpr TimeNs minute = 60 * ns_per_s;

class EventLogTest : public test::ExecutiveTest {
 protected:
  [[nodiscard]] std::int64_t count(StatusCode code) { return static_cast<std::int64_t>(events(code).size()); }
  /// Events with this code that `events_repeated` has told.
  std::int64_t reported(StatusCode code) {
    std::int64_t sum = 0;
    for (const EventRecord& event : events(StatusCode::events_repeated)) {
      if (event.b == static_cast<std::int64_t>(code)) sum += event.a;
    }
    return sum;
  }

  EventLog log{store};
};

TEST_F(EventLogTest, AFloodIsCountedOnceAMinuteAndPushesNothingOut) {
  constexpr std::int64_t per_s = 2000, seconds = 600;
  for (std::int64_t i = 0; i < per_s * seconds; ++i) {
    const TimeNs time = i * (ns_per_s / per_s);
    log.report(time, "navigator", {StatusCode::navigation_refused, i});
    if (i % (per_s * 5) == 0) log.report_due(time);
    // What else happens is told at once, of the same component too.
    if (i == per_s * 90) log.report(time, "navigator", {StatusCode::assertion_failed, 7});
    if (i == per_s * 90) log.report(time, "overlap", {StatusCode::navigation_refused, 8});
  }
  // The allowance, and then one a minute beside the number of the others.
  EXPECT_EQ(count(StatusCode::navigation_refused), EventLog::burst + seconds / 60 - 1 + 1);
  EXPECT_EQ(count(StatusCode::events_repeated), seconds / 60 - 1);
  ASSERT_EQ(count(StatusCode::assertion_failed), 1);
  EXPECT_EQ(events(StatusCode::assertion_failed)[0].time_ns, 90 * ns_per_s);
  EXPECT_STREQ(events(StatusCode::events_repeated)[0].component, "navigator");
  log.report_due(seconds * ns_per_s, true);
  EXPECT_EQ(count(StatusCode::navigation_refused) - 1 + reported(StatusCode::navigation_refused), per_s * seconds);
  std::int64_t all = 0;
  ASSERT_TRUE(newest_id<EventRecord>(store, all).ok());
  EXPECT_LT(all, limits::max_events / 100) << "of the history's room, in ten minutes";
}

TEST_F(EventLogTest, AFloodThatLastsLeavesTheHistoryDays) {
  constexpr std::int64_t hours = 24;
  for (TimeNs time = 0; time < hours * 60 * minute; time += 5 * ns_per_s) {
    log.report(time, "navigator", StatusCode::navigation_refused);
    log.report_due(time);
  }
  std::int64_t all = 0;
  ASSERT_TRUE(newest_id<EventRecord>(store, all).ok());
  EXPECT_LT(all, limits::max_events / 6) << "less than one sixth of the history in a day";
}

TEST_F(EventLogTest, AnAllowanceIsWholeAgainAfterAQuietTime) {
  for (int round = 1; round <= 3; ++round) {
    for (int i = 0; i < EventLog::burst; ++i) log.report(clock.now(), "a", StatusCode::image_too_large);
    EXPECT_EQ(count(StatusCode::image_too_large), round * EventLog::burst);
    clock.sleep_until(clock.now() + EventLog::burst * EventLog::interval_ns);
    log.report_due(clock.now());
  }
  EXPECT_EQ(count(StatusCode::events_repeated), 0);
}

TEST_F(EventLogTest, WhatWasCountedIsToldWithoutAnotherEvent) {
  for (int i = 0; i < 100; ++i) log.report(0, "a", StatusCode::image_too_large);
  log.report_due(minute - 1);
  EXPECT_EQ(reported(StatusCode::image_too_large), 0);
  log.report_due(minute);
  EXPECT_EQ(reported(StatusCode::image_too_large), 100 - EventLog::burst);
  log.report_due(5 * minute);
  log.report_due(6 * minute, true);
  EXPECT_EQ(count(StatusCode::events_repeated), 1) << "once";
}

TEST_F(EventLogTest, TheFirstEventWithACodeIsWrittenHoweverManyOthersFlood) {
  constexpr int names = 3 * static_cast<int>(EventLog::max_allowances), rounds = 5, each = 100;
  for (int round = 0; round < rounds; ++round) {
    for (int n = 0; n < names; ++n) {
      const std::string name = "component " + std::to_string(n);
      for (int i = 0; i < each; ++i) log.report(0, name.c_str(), StatusCode::io_error);
    }
  }
  log.report(0, "board", {StatusCode::memory_damaged, 5});
  EXPECT_EQ(count(StatusCode::memory_damaged), 1);
  log.report_due(0, true);
  EXPECT_EQ(count(StatusCode::io_error) + reported(StatusCode::io_error), names * rounds * each) << "none is hidden";
}

TEST_F(EventLogTest, ATimeThatGoesBackSilencesNothing) {
  for (int i = 0; i < 100; ++i) log.report(1000 * minute, "a", StatusCode::image_too_large);
  log.report(0, "a", StatusCode::image_too_large);
  EXPECT_EQ(count(StatusCode::image_too_large), EventLog::burst + 1);
  log.report_due(1);
  EXPECT_EQ(reported(StatusCode::image_too_large), 100 - EventLog::burst);
}

TEST_F(EventLogTest, EventsThatCouldNotBeStoredAreCountedInTheLogAfterwards) {
  test::RefusingStore refusing(store);
  EventLog full(refusing);
  full.report(1, "a", StatusCode::io_error);
  refusing.full = true;
  full.report(2, "a", StatusCode::store_full);
  full.report(3, "a", StatusCode::io_error);
  refusing.full = false;
  full.report_due(4);
  full.report_due(5);
  full.report(6, "a", StatusCode::io_error);
  EXPECT_EQ(events(StatusCode::io_error).size(), 2U);
  const std::vector<EventRecord> lost = events(StatusCode::events_lost);
  ASSERT_EQ(lost.size(), 1U);
  EXPECT_EQ(lost[0].a, 2);
  EXPECT_EQ(lost[0].b, static_cast<std::int64_t>(StatusCode::store_full));
  EXPECT_EQ(lost[0].time_ns, 4);
}

TEST_F(EventLogTest, AStoreThatFailsEverySecondTimeIsToldWithinTheLimit) {
  test::RefusingStore refusing(store);
  EventLog failing(refusing);
  for (int i = 0; i < 1000; ++i) {
    refusing.full = i % 2 == 0;
    failing.report(i, "a", {StatusCode::io_error, i});
  }
  EXPECT_LE(count(StatusCode::events_lost), EventLog::burst);
  refusing.full = false;
  failing.report_due(EventLog::interval_ns, true);
  std::int64_t lost = 0;
  for (const EventRecord& event : events(StatusCode::events_lost)) lost += event.a;
  EXPECT_EQ(count(StatusCode::io_error) + reported(StatusCode::io_error) + lost, 1000);
}

}  // namespace
}  // namespace ilp
