#include "fsw/base/date_text.hpp"

namespace ilp {
namespace {

constexpr int first_year = 1970, end_of_years = 2200;

bool is_leap_year(int year) {
  return year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
}

int days_of(int month, int year) {
  constexpr int days[] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  return days[month - 1] + (month == 2 && is_leap_year(year) ? 1 : 0);
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// The next `digits` digits as a number; -1 where they are not there.
int take_number(const char*& text, int digits) {
  int value = 0;
  for (int i = 0; i < digits; ++i) {
    if (!is_digit(*text)) return -1;
    value = 10 * value + (*text++ - '0');
  }
  return value;
}

bool take(const char*& text, char c) {
  if (*text != c) return false;
  ++text;
  return true;
}

/// Digits of a fraction of the second, ns; -1 without any.
TimeNs take_fraction(const char*& text) {
  if (!is_digit(*text)) return -1;
  TimeNs unit = ns_per_s, value = 0;
  for (; is_digit(*text); ++text) {  // bound: the text
    unit /= 10;
    value += unit * (*text - '0');
  }
  return value;
}

/// What stands behind the time of the day, to the end of the text.
DateClock take_zone(const char* text, TimeNs& zone) {
  zone = 0;
  if (*text == 0) return DateClock::unknown;
  if ((*text == 'Z' || *text == 'z') && text[1] == 0) return DateClock::utc;
  const bool west = *text == '-';
  if (!west && *text != '+') return DateClock::none;
  ++text;
  const int hours = take_number(text, 2);
  int minutes = 0;
  if (hours >= 0 && *text != 0) {
    static_cast<void>(take(text, ':'));
    minutes = take_number(text, 2);
  }
  if (hours < 0 || hours > 14 || minutes < 0 || minutes > 59 || *text != 0) return DateClock::none;
  zone = (west ? -1 : 1) * TimeNs{hours * 60 + minutes} * 60 * ns_per_s;
  return DateClock::utc;
}

}  // namespace

bool time_of_date(int year, int month, int day, int hour, int minute, int second, TimeNs& since_1970) {
  if (year < first_year || year >= end_of_years || month < 1 || month > 12) return false;
  const bool valid = day >= 1 && day <= days_of(month, year) && hour >= 0 && hour < 24 && minute >= 0 && minute < 60 &&
                     second >= 0 && second <= 60;
  if (!valid) return false;
  TimeNs days = day - 1;
  for (int y = first_year; y < year; ++y) days += is_leap_year(y) ? 366 : 365;
  for (int m = 1; m < month; ++m) days += days_of(m, year);
  since_1970 = (((days * 24 + hour) * 60 + minute) * 60 + second) * ns_per_s;
  return true;
}

DateClock read_date(const char* text, TimeNs& since_1970) {
  const int year = take_number(text, 4);
  if (year < 0 || !take(text, '-')) return DateClock::none;
  const int month = take_number(text, 2);
  if (month < 0 || !take(text, '-')) return DateClock::none;
  const int day = take_number(text, 2);
  if (day < 0 || (!take(text, 'T') && !take(text, ' '))) return DateClock::none;
  const int hour = take_number(text, 2);
  if (hour < 0 || !take(text, ':')) return DateClock::none;
  const int minute = take_number(text, 2);
  if (minute < 0 || !take(text, ':')) return DateClock::none;
  const int second = take_number(text, 2);
  TimeNs fraction = 0, zone = 0, whole = 0;
  if (second >= 0 && take(text, '.')) fraction = take_fraction(text);
  if (fraction < 0 || !time_of_date(year, month, day, hour, minute, second, whole)) return DateClock::none;
  const DateClock clock = take_zone(text, zone);
  if (clock != DateClock::none) since_1970 = whole + fraction - zone;
  return clock;
}

}  // namespace ilp
