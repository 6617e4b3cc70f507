// Converts dates of ISO 8601 to numbers.
#pragma once

#include <cstdint>

#include "fsw/base/time.hpp"

namespace ilp {

/// Converts a date to nanoseconds since 1970-01-01T00:00:00 of the same clock, without leap seconds. Returns false for
/// a day that the calendar does not have, a year outside of 1970 to 2199, or an invalid time of day. Second 60 is the
/// first second of the next minute.
[[nodiscard]] bool time_of_date(int year, int month, int day, int hour, int minute, int second, TimeNs& since_1970);

enum class DateClock : std::uint8_t {
  none,     ///< the text is no date
  utc,      ///< the text has Z or a time zone: the result is UTC
  unknown,  ///< the text has no time zone: the result is in an unknown local time
};

/// Reads YYYY-MM-DDThh:mm:ss[.fraction][Z|+hh:mm|+hhmm|+hh]; T may be a blank, and + may be -. Digits below nanoseconds
/// are ignored. `since_1970` changes only if the text is a date.
[[nodiscard]] DateClock read_date(const char* text, TimeNs& since_1970);

}  // namespace ilp
