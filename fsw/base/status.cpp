#include "fsw/base/status.hpp"

#include <array>
#include <cstddef>
#include <iterator>

namespace ilp {
namespace {

struct StatusEntry {
  const char* name;
  Severity severity;
  const char* text;
  const char* advice;
};

constexpr StatusEntry entries[] = {
#define ILP_STATUS(number, name, severity, text, advice) {#name, Severity::severity, text, advice},
#include "fsw/base/status_list.inc"
#undef ILP_STATUS
};
constexpr std::uint16_t numbers[] = {
#define ILP_STATUS(number, name, severity, text, advice) number,
#include "fsw/base/status_list.inc"
#undef ILP_STATUS
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

AssertionPlace last_assertion() {
  return latest_assertion;
}

Status assertion_failure(const char* file, std::int32_t line, std::int64_t value) {
  latest_assertion = {file, line};
  return {StatusCode::assertion_failed, line, value};
}

}  // namespace ilp
