// Flight statuses and events as host errors and in words for the operator.
#pragma once

#include <string>

#include "fsw/base/status.hpp"
#include "fsw/records/records.hpp"

namespace ilp::host {

/// The text of the status list with its values filled in.
[[nodiscard]] std::string status_sentence(const Status& status);
/// The same, and what to do.
[[nodiscard]] std::string describe(const Status& status);
/// Throws std::runtime_error("WHAT: ...") unless the status is ok.
void require(const Status& status, const std::string& what);

// Statuses and verdicts in words for the operator.

/// Name, text and advice of an event's code; a code from another software version is named by its number.
[[nodiscard]] std::string event_name(std::uint16_t code);
[[nodiscard]] std::string event_sentence(const EventRecord& event);
[[nodiscard]] std::string event_advice(std::uint16_t code);
/// The number is that of an event's reporter.
[[nodiscard]] std::string component_name(std::uint64_t number);
[[nodiscard]] const char* severity_name(std::uint8_t severity);

}  // namespace ilp::host
