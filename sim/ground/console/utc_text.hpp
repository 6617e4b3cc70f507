// Converts UTC times to and from the operator's text.
#pragma once

#include <optional>
#include <string>

#include "fsw/packets/time_code.hpp"

namespace ilp::console {

/// Text such as 2026-11-22T08:40:12.345Z.
[[nodiscard]] std::string utc_text(UtcNs utc);
/// Text such as 08:40:12.
[[nodiscard]] std::string clock_text(UtcNs utc);
/// Duration as text, such as 1:02:03 or 02:03, rounded to seconds.
[[nodiscard]] std::string duration_clock(TimeNs duration);

/// Parses `+S`, which is S seconds after `now`, or a time in the format of utc_text, with or without fraction and Z.
/// None for any other text.
[[nodiscard]] std::optional<UtcNs> parse_instant(const std::string& text, UtcNs now);

}  // namespace ilp::console
