// Errors as values: a code and two numbers that an event report can carry. status_list.inc lists the codes with text,
// severity and advice (architecture, "Errors").
#pragma once

#include <cstdint>

#include "fsw/base/enumeration.hpp"

namespace ilp {

enum class StatusCode : std::uint16_t {
#define ILP_STATUS(number, name, severity, text, advice, ...) name = (number),
#include "fsw/base/status_list.inc"
#undef ILP_STATUS
};
/// All codes are below this limit. Numbers of removed codes are never used again, so that some numbers below the limit
/// are no codes.
inline constexpr std::uint16_t status_code_limit = 256;
/// Whether status_list.inc has a code of this number.
[[nodiscard]] bool is_status_code(std::uint64_t number);

/// Severities of ECSS-E-ST-70-41C service 5.
ILP_ENUMERATION(Severity, (0, info, ""), (1, low, ""), (2, medium, ""), (3, high, ""))

/// A code and its two values, whose meanings are in the code's row of status_list.inc.
struct [[nodiscard]] Status {
  StatusCode code = StatusCode::ok;
  std::int64_t a = 0;
  std::int64_t b = 0;

  constexpr Status() = default;
  // Implicit on purpose: it allows `return StatusCode::not_ready;`.
  constexpr Status(StatusCode status_code, std::int64_t value_a = 0, std::int64_t value_b = 0)
      : code(status_code), a(value_a), b(value_b) {}

  [[nodiscard]] constexpr bool ok() const { return code == StatusCode::ok; }
  [[nodiscard]] constexpr bool is(StatusCode other) const { return code == other; }
};

/// The identifier of the code in status_list.inc. For an unknown number it is that of the first fault.
[[nodiscard]] const char* status_name(StatusCode code);
/// One sentence with the placeholders %a and %b for the values.
[[nodiscard]] const char* status_text(StatusCode code);
[[nodiscard]] const char* status_advice(StatusCode code);
[[nodiscard]] Severity status_severity(StatusCode code);

/// The requested object does not exist, or is no longer available.
[[nodiscard]] constexpr bool is_gone(const Status& status) {
  return status.is(StatusCode::not_found) || status.is(StatusCode::record_damaged);
}

/// The fault is transient: the same call may succeed later, and the requested data may be intact. Every other fault is
/// final: a repeated call returns the same fault.
[[nodiscard]] constexpr bool is_transient(const Status& status) {
  switch (status.code) {
    case StatusCode::io_error:
    case StatusCode::store_error:
    case StatusCode::store_lost:
    case StatusCode::store_locked:
    case StatusCode::store_full:
    case StatusCode::store_damaged:  // the next start quarantines or salvages the whole database
    case StatusCode::arena_exhausted:
      return true;
    default:
      return false;
  }
}

/// Source file and line of the latest failed assertion. The executive puts them into the event report.
struct AssertionPlace {
  const char* file = nullptr;
  std::int32_t line = 0;
};
[[nodiscard]] AssertionPlace last_assertion();
/// Records file and line, and returns the Status with which the step fails.
Status assertion_failure(const char* file, std::int32_t line, std::int64_t value);

}  // namespace ilp

/// Invariant that stays active in flight: a violation fails the step with an event and never aborts (decisions.md 13).
#define ILP_ASSERT(condition, value)                                                                         \
  do {                                                                                                       \
    if (!(condition)) return ::ilp::assertion_failure(__FILE__, __LINE__, static_cast<std::int64_t>(value)); \
  } while (false)

/// Returns the Status of `expression` from this function unless it is ok.
#define ILP_TRY(expression)                            \
  do {                                                 \
    const ::ilp::Status ilp_try_status = (expression); \
    if (!ilp_try_status.ok()) return ilp_try_status;   \
  } while (false)
