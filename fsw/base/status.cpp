#include "fsw/base/status.hpp"

#include <array>
#include <cstddef>
#include <iterator>

#include "fsw/base/argument.hpp"
#include "fsw/base/status_values.hpp"

namespace ilp {
namespace {

struct StatusEntry {
  const char* name;
  Severity severity;
  const char* text;
  const char* advice;
  StatusValues values;
};

#define ILP_STATUS_VALUE(name, type) {#name, ValueType::type},
constexpr StatusEntry entries[] = {
#define ILP_STATUS(number, name, severity, text, advice, ...) \
  {#name, Severity::severity, text, advice, {__VA_OPT__(ILP_ENUM_EACH(ILP_STATUS_VALUE, __VA_ARGS__))}},
#include "fsw/base/status_list.inc"
#undef ILP_STATUS
};
constexpr std::uint16_t numbers[] = {
#define ILP_STATUS(number, name, severity, text, advice, ...) number,
#include "fsw/base/status_list.inc"
#undef ILP_STATUS
};

constexpr ValueTypeInfo value_types[] = {
#define ILP_VALUE_TYPE(name, unit, per_unit, meaning) {#name, unit, per_unit, meaning},
    ILP_VALUE_TYPES(ILP_VALUE_TYPE)
#undef ILP_VALUE_TYPE
};

constexpr std::uint8_t no_row = 0xFF;
using RowTable = std::array<std::uint8_t, status_code_limit>;

constexpr RowTable make_rows() {
  RowTable rows{};
  for (std::uint8_t& row : rows) row = no_row;
  for (std::size_t i = 0; i < std::size(numbers); ++i) {
    // A number that is too large or used twice does not compile.
    if (rows.at(numbers[i]) != no_row) return {};
    rows.at(numbers[i]) = static_cast<std::uint8_t>(i);
  }
  return rows;
}
constexpr RowTable rows = make_rows();
static_assert(std::size(entries) < no_row && rows[1] == 1, "a number of status_list.inc is there twice");

const StatusEntry& entry(StatusCode code) {
  // A code from outside may have any value.
  return entries[is_status_code(static_cast<std::uint64_t>(code)) ? rows[static_cast<std::size_t>(code)] : 1];
}

AssertionPlace latest_assertion;

}  // namespace

bool is_status_code(std::uint64_t number) {
  return number < status_code_limit && rows[static_cast<std::size_t>(number)] != no_row;
}

const char* status_name(StatusCode code) {
  return entry(code).name;
}
const char* status_text(StatusCode code) {
  return entry(code).text;
}
const char* status_advice(StatusCode code) {
  return entry(code).advice;
}
Severity status_severity(StatusCode code) {
  return entry(code).severity;
}

StatusValues status_values(StatusCode code) {
  return entry(code).values;
}
const ValueTypeInfo& info_of(ValueType type) {
  return value_types[type < ValueType::count ? static_cast<std::size_t>(type) : 0];
}

Status out_of_range(Argument argument, double value) {
  constexpr double most = 9.2e18;
  const double thousandths = value * 1000;
  // This is false for what is not a number.
  if (!(thousandths > -most && thousandths < most)) return out_of_range(argument);
  return {StatusCode::invalid_argument, static_cast<std::int64_t>(argument),
          static_cast<std::int64_t>(thousandths < 0 ? thousandths - 0.5 : thousandths + 0.5)};
}
Status out_of_range(Argument argument) {
  return {StatusCode::invalid_argument, static_cast<std::int64_t>(argument), no_number};
}

AssertionPlace last_assertion() {
  return latest_assertion;
}

Status assertion_failure(const char* file, std::int32_t line, std::int64_t value) {
  latest_assertion = {file, line};
  return {StatusCode::assertion_failed, line, value};
}

}  // namespace ilp
