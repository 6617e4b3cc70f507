#include "fsw/base/status.hpp"

#include <cstddef>

namespace ilp {
namespace {

struct StatusEntry {
  const char* name;
  Severity severity;
  const char* text;
  const char* advice;
};

constexpr StatusEntry entries[] = {
#define ILP_STATUS(name, severity, text, advice) {#name, Severity::severity, text, advice},
#include "fsw/base/status_list.inc"
#undef ILP_STATUS
};
static_assert(sizeof(entries) / sizeof(entries[0]) == static_cast<std::size_t>(StatusCode::count));

const StatusEntry& entry(StatusCode code) {
  const auto index = static_cast<std::size_t>(code);
  // A code read from outside may be anything.
  return entries[index < static_cast<std::size_t>(StatusCode::count) ? index : 1];
}

AssertionPlace latest_assertion;

}  // namespace

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
