// Statuses and verdicts in words for the operator.
#pragma once

#include <string>

#include "fsw/base/status.hpp"
#include "fsw/records/records.hpp"

namespace ilp::ground {

/// The text of the status list with its two values filled in.
[[nodiscard]] std::string status_sentence(const Status& status);
/// Name, text and advice of an event's code; a code from another software version is named by its number.
[[nodiscard]] std::string event_name(std::uint16_t code);
[[nodiscard]] std::string event_sentence(const EventRecord& event);
[[nodiscard]] std::string event_advice(std::uint16_t code);
[[nodiscard]] const char* severity_name(std::uint8_t severity);

[[nodiscard]] const char* strip_end_words(StripEnd end);
[[nodiscard]] const char* depth_verdict_words(DepthVerdict verdict);
[[nodiscard]] const char* pose_verdict_words(std::uint8_t sequence_verdict);
[[nodiscard]] const char* overlap_verdict_words(std::uint8_t overlap_verdict);
[[nodiscard]] const char* scheme_words(ProductScheme scheme);

}  // namespace ilp::ground
