#include "sim/ground/console/utc_text.hpp"

#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>

namespace ilp::console {
namespace {

using namespace std::chrono;

constexpr sys_days epoch = year{1958} / 1 / 1;
constexpr double longest_s = 4e9;

template <typename... Values>
std::string print(const char* format, Values... values) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

std::optional<UtcNs> parse_calendar(const std::string& text) {
  int y = 0, mo = 0, d = 0, h = 0, mi = 0, read = 0;
  double s = 0;
  if (std::sscanf(text.c_str(), "%4d-%2d-%2dT%2d:%2d:%lf%n", &y, &mo, &d, &h, &mi, &s, &read) != 6) return std::nullopt;
  const std::string rest = text.substr(static_cast<std::size_t>(read));
  const year_month_day date{year{y}, month{static_cast<unsigned>(mo)}, day{static_cast<unsigned>(d)}};
  const bool good = (rest.empty() || rest == "Z") && mo >= 1 && d >= 1 && date.ok() && y >= 1958 && y < 2250 &&
                    h >= 0 && h < 24 && mi >= 0 && mi < 60 && s >= 0 && s < 60;
  if (!good) return std::nullopt;
  const std::int64_t minutes = ((sys_days{date} - epoch).count() * 24 + h) * 60 + mi;
  return minutes * 60 * ns_per_s + std::llround(s * 1e9);
}

}  // namespace

std::string utc_text(UtcNs utc) {
  const auto days_since = static_cast<int>(utc / (seconds_per_day * ns_per_s));
  const year_month_day date{epoch + days{days_since}};
  const auto ms = static_cast<int>(utc / ns_per_ms % 1000);
  return print("%04d-%02u-%02uT", static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
               static_cast<unsigned>(date.day())) +
         clock_text(utc) + print(".%03dZ", ms);
}

std::string clock_text(UtcNs utc) {
  const auto second = static_cast<int>(utc / ns_per_s % seconds_per_day);
  return print("%02d:%02d:%02d", second / 3600, second / 60 % 60, second % 60);
}

std::string duration_clock(TimeNs duration) {
  const long long s = std::llround(static_cast<double>(duration) / 1e9);
  return s >= 3600 ? print("%lld:%02lld:%02lld", s / 3600, s / 60 % 60, s % 60)
                   : print("%02lld:%02lld", s / 60, s % 60);
}

std::optional<UtcNs> parse_instant(const std::string& text, UtcNs now) {
  if (text.empty() || text[0] != '+') return parse_calendar(text);
  double seconds = 0;
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data() + 1, end, seconds);
  if (error != std::errc() || rest != end || !(seconds >= 0 && seconds < longest_s)) return std::nullopt;
  return now + std::llround(seconds * 1e9);
}

}  // namespace ilp::console
