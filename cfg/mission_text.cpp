#include "cfg/mission_text.hpp"

#include <cstring>

#include "fsw/base/text.hpp"

namespace ilp {
namespace {

constexpr int most_digits = 15;
/// Powers of ten up to this one are doubles without rounding.
constexpr int largest_exact_power = 22;

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// Without blanks at both ends; `text` is shortened in place.
char* trimmed(char* text) {
  while (is_blank(*text)) ++text;
  std::size_t size = std::strlen(text);
  while (size > 0 && is_blank(text[size - 1])) text[--size] = 0;
  return text;
}

/// A comment begins with the line or behind a blank.
void cut_comment(char* text) {
  for (char* c = text; *c != 0; ++c) {
    const bool begins = c == text || is_blank(c[-1]);
    if (begins && (*c == ';' || *c == '#')) {
      *c = 0;
      return;
    }
  }
}

bool parse_exponent(const char* text, int& exponent) {
  const bool negative = *text == '-';
  if (*text == '-' || *text == '+') ++text;
  if (!is_digit(*text)) return false;
  int value = 0;
  for (; is_digit(*text); ++text) value = value < 1000 ? 10 * value + (*text - '0') : value;
  exponent += negative ? -value : value;
  return *text == 0;
}

}  // namespace

bool parse_decimal(const char* text, double& value) {
  const bool negative = *text == '-';
  if (*text == '-' || *text == '+') ++text;
  std::int64_t mantissa = 0;
  int digits = 0;
  int exponent = 0;
  bool any = false;
  bool point = false;
  for (; is_digit(*text) || (*text == '.' && !point); ++text) {
    if (*text == '.') {
      point = true;
      continue;
    }
    any = true;
    if (mantissa != 0 || *text != '0') ++digits;
    if (digits > most_digits) return false;
    mantissa = 10 * mantissa + (*text - '0');
    if (point) --exponent;
  }
  if (!any) return false;
  if (*text == 'e' || *text == 'E') {
    if (!parse_exponent(text + 1, exponent)) return false;
  } else if (*text != 0) {
    return false;
  }
  const int power = exponent < 0 ? -exponent : exponent;
  if (mantissa != 0 && power > largest_exact_power) return false;
  double scale = 1;
  for (int i = 0; mantissa != 0 && i < power; ++i) scale *= 10;
  // Both are exact: one rounding, the right one.
  const auto whole = static_cast<double>(mantissa);
  const double magnitude = exponent < 0 ? whole / scale : whole * scale;
  value = negative ? -magnitude : magnitude;
  return true;
}

Status MissionText::take_line() {
  if (too_long_) return {StatusCode::parse_error, line_};
  text_[size_] = 0;
  if (std::strlen(text_) != size_) return {StatusCode::parse_error, line_};
  // Some editors begin a file with the mark of its byte order.
  char* text = line_ == 1 && std::strncmp(text_, "\xEF\xBB\xBF", 3) == 0 ? text_ + 3 : text_;
  cut_comment(text);
  text = trimmed(text);
  if (*text == 0) return {};
  if (*text == '[') {
    char* end = std::strchr(text, ']');
    if (end == nullptr || end[1] != 0) return {StatusCode::parse_error, line_};
    *end = 0;
    copy_text(section_, trimmed(text + 1));
    return {};
  }
  char* equals = std::strpbrk(text, "=:");
  if (equals == nullptr) return {StatusCode::parse_error, line_};
  *equals = 0;
  double value = 0;
  if (!parse_decimal(trimmed(equals + 1), value)) return {StatusCode::invalid_argument, line_};
  const Status status = set_parameter(mission_, section_, trimmed(text), value);
  return status.ok() ? status : Status{status.code, line_};
}

void MissionText::end_line() {
  const Status status = take_line();
  if (status_.ok()) status_ = status;
  ++line_;
  size_ = 0;
  too_long_ = false;
}

void MissionText::add(std::span<const std::uint8_t> text) {
  for (const std::uint8_t octet : text) {
    if (octet == '\n') {
      end_line();
    } else if (size_ + 1 < sizeof(text_)) {
      text_[size_++] = static_cast<char>(octet);
    } else {
      too_long_ = true;
    }
  }
}

Status MissionText::finish(MissionParameters& mission) {
  end_line();
  ILP_TRY(status_);
  const Status valid = validate(mission_);
  if (!valid.ok()) return {valid.code, 0, valid.a};
  mission = mission_;
  return {};
}

}  // namespace ilp
