// Dates as numbers, against the calendar of the C++ library.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <string>

#include "fsw/base/date_text.hpp"

namespace ilp {
namespace {

TEST(DateTextTest, EveryDayOfTheCalendarAndNoOther) {
  using namespace std::chrono;
  for (int y = 1968; y < 2203; ++y) {
    for (int m = 0; m <= 13; ++m) {
      for (int d = 0; d <= 32; ++d) {
        const year_month_day date{year{y}, month{static_cast<unsigned>(m)}, day{static_cast<unsigned>(d)}};
        TimeNs time = -1;
        const bool valid = time_of_date(y, m, d, 1, 2, 3, time);
        ASSERT_EQ(valid, date.ok() && y >= 1970 && y < 2200) << y << "-" << m << "-" << d;
        if (!valid) continue;
        const std::int64_t days = sys_days{date}.time_since_epoch().count();
        ASSERT_EQ(time, (days * 86'400 + 3723) * ns_per_s) << y << "-" << m << "-" << d;
      }
    }
  }
}

TEST(DateTextTest, ZonesFractionsAndWhatIsNoDate) {
  TimeNs time = 0;
  ASSERT_EQ(read_date("2026-11-22T08:40:08Z", time), DateClock::utc);
  const TimeNs utc = time;
  EXPECT_EQ(utc, 1'795'336'808 * ns_per_s);  // date -u -d 2026-11-22T08:40:08Z +%s
  for (const char* same : {"2026-11-22 08:40:08z", "2026-11-22T10:10:08+01:30", "2026-11-22T10:10:08+0130",
                           "2026-11-22T06:40:08-02", "2026-11-22T08:40:08.000Z"}) {
    time = 0;
    EXPECT_EQ(read_date(same, time), DateClock::utc) << same;
    EXPECT_EQ(time, utc) << same;
  }
  EXPECT_EQ(read_date("2026-11-22T08:40:08.1234567899", time), DateClock::unknown);
  EXPECT_EQ(time, utc + 123'456'789);
  EXPECT_EQ(read_date("2024-02-29T00:00:00Z", time), DateClock::utc);
  const TimeNs before = time;
  for (const char* none : {"2026-02-31T08:40:08Z", "2025-02-29T00:00:00Z", "2026-13-01T00:00:00Z", "2026-11-22",
                           "2026-11-22T24:00:00Z", "2026-11-22T08:40:08+15", "2026-11-22T08:40:08 UTC", "",
                           "2026-11-22T08:40:08.Z", "26-11-22T08:40:08Z", "2026-11-22T08:40:61Z", "1.5"}) {
    EXPECT_EQ(read_date(none, time), DateClock::none) << none;
    EXPECT_EQ(time, before) << none;
  }
}

}  // namespace
}  // namespace ilp
