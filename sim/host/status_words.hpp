// Statuses and verdicts in words for the operator.
#pragma once

#include <string>

#include "fsw/base/status.hpp"
#include "fsw/records/records.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::host {

/// Name, text and advice of an event's code; a code from another software version is named by its number.
[[nodiscard]] std::string event_name(std::uint16_t code);
[[nodiscard]] std::string event_sentence(const EventRecord& event);
[[nodiscard]] std::string event_advice(std::uint16_t code);
[[nodiscard]] const char* severity_name(std::uint8_t severity);

}  // namespace ilp::host
