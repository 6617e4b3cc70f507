// Instants of UTC as operators write and read them.
#pragma once

#include <optional>
#include <string>

#include "fsw/packets/time_code.hpp"

namespace ilp::console {

/// 2026-11-22T08:40:12.345Z
[[nodiscard]] std::string utc_text(UtcNs utc);
/// 08:40:12
[[nodiscard]] std::string clock_text(UtcNs utc);
/// 1:02:03 or 02:03 of a duration, its seconds rounded.
[[nodiscard]] std::string duration_clock(TimeNs duration);

/// `+S` seconds after `now`, or an instant as utc_text writes it, with or without fraction and Z; none for anything
/// else.
[[nodiscard]] std::optional<UtcNs> parse_instant(const std::string& text, UtcNs now);

}  // namespace ilp::console
