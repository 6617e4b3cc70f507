// Dates of ISO 8601 as numbers.
#pragma once

#include <cstdint>

#include "fsw/base/time.hpp"

namespace ilp {

/// Nanoseconds from 1970-01-01T00:00:00 to an instant of the same clock, without leap seconds. False for a day that the
/// calendar does not have, such as 31 February, for a year outside of 1970 to 2199 and for no time of a day; a second
/// of 60 is the first one of the next minute.
[[nodiscard]] bool time_of_date(int year, int month, int day, int hour, int minute, int second, TimeNs& since_1970);

enum class DateClock : std::uint8_t {
  none,     ///< the text is no date
  utc,      ///< with Z or a zone, which has been taken away
  unknown,  ///< without a zone: of a clock on somebody's wall
};

/// YYYY-MM-DDThh:mm:ss[.fraction][Z|+hh:mm|+hhmm|+hh], with a blank in place of T. Digits beyond nanoseconds are left
/// out. `since_1970` changes only where the text is a date.
[[nodiscard]] DateClock read_date(const char* text, TimeNs& since_1970);

}  // namespace ilp
