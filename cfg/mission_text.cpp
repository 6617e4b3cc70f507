#include "cfg/mission_text.hpp"

#include <cmath>
#include <cstdlib>
#include <cstring>

#include "fsw/base/text.hpp"

namespace ilp {
namespace {

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

/// Removes the blanks at both ends; `text` is changed in place.
char* trimmed(char* text) {
  while (is_blank(*text)) ++text;
  std::size_t size = std::strlen(text);
  while (size > 0 && is_blank(text[size - 1])) text[--size] = 0;
  return text;
}

/// A comment begins at the start of a line or after a blank.
void cut_comment(char* text) {
  for (char* c = text; *c != 0; ++c) {
    const bool begins = c == text || is_blank(c[-1]);
    if (begins && (*c == ';' || *c == '#')) {
      *c = 0;
      return;
    }
  }
}

constexpr double radians_per_degree = 0.017453292519943295;

/// Radians, or degrees with `deg` behind the number.
bool parse_angle(const char* text, double& value) {
  const std::size_t size = std::strlen(text);
  if (size < 3 || std::strcmp(text + size - 3, "deg") != 0) return parse_decimal(text, value);
  char digits[32];
  if (size - 3 >= sizeof(digits)) return false;
  std::memcpy(digits, text, size - 3);
  digits[size - 3] = 0;
  if (!parse_decimal(digits, value)) return false;
  value *= radians_per_degree;
  return true;
}

}  // namespace

bool parse_decimal(const char* text, double& value) {
  const char* const digits = *text == '-' || *text == '+' ? text + 1 : text;
  // This refuses "inf" and "nan", which begin with neither a digit nor a point, and hexadecimal numbers.
  if (*digits != '.' && (*digits < '0' || *digits > '9')) return false;
  if (std::strpbrk(digits, "xX") != nullptr) return false;
  const bool zero = std::strcspn(digits, "123456789") >= std::strcspn(digits, "eE");
  char* rest = nullptr;
  value = std::strtod(text, &rest);
  return *rest == 0 && rest != text && std::isfinite(value) && (zero || value != 0);
}

bool parse_value(const ParameterInfo& info, const char* text, double& value) {
  const EnumValue* const choice = find_value(info.choices, text);
  if (choice == nullptr)
    return std::strcmp(info.unit, "rad") == 0 ? parse_angle(text, value) : parse_decimal(text, value);
  value = choice->number;
  return true;
}

Status MissionText::take_entry(const char* key, const char* text) {
  const std::size_t index = find_parameter(section_, key);
  Status status{StatusCode::not_found, line_};
  if (index < parameter_count()) {
    double value = 0;
    const ParameterInfo& info = parameter_info(index);
    const bool good = parse_value(info, text, value) && set_parameter(mission_, index, value).ok();
    status = good ? Status{} : Status{StatusCode::parameter_out_of_range, info.number, line_};
  }
  if (status.ok() || !status_.ok()) return status;
  copy_text(fault_.section, section_);
  copy_text(fault_.key, key);
  copy_text(fault_.value, text);
  return status;
}

Status MissionText::take_line() {
  if (too_long_) return {StatusCode::parse_error, line_};
  text_[size_] = 0;
  if (std::strlen(text_) != size_) return {StatusCode::parse_error, line_};
  // Some editors begin a file with a byte order mark.
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
  return take_entry(trimmed(text), trimmed(equals + 1));
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
  ILP_TRY(validate(mission_));
  mission = mission_;
  return {};
}

}  // namespace ilp
