// Converts flight statuses to exceptions, and statuses and events to text for the operator.
#pragma once

#include <string>

#include "fsw/base/status.hpp"
#include "fsw/records/records.hpp"

namespace ilp::host {

/// The text of the status list (fsw/base/status_list.inc) with the status's values filled in.
[[nodiscard]] std::string status_sentence(const Status& status);
/// status_sentence, and in parentheses what to do.
[[nodiscard]] std::string describe(const Status& status);
/// Throws std::runtime_error("WHAT: DESCRIPTION") unless the status is ok.
void require(const Status& status, const std::string& what);

// Events as text.

/// Name, text and advice for an event's code. A code that this version does not know is given as a number.
[[nodiscard]] std::string event_name(std::uint16_t code);
[[nodiscard]] std::string event_sentence(const EventRecord& event);
[[nodiscard]] std::string event_advice(std::uint16_t code);
/// Name of the component that reported an event, from its number in the event.
[[nodiscard]] std::string component_name(std::uint64_t number);
[[nodiscard]] const char* severity_name(std::uint8_t severity);

}  // namespace ilp::host
