// ST[05] events: reports, and lists of events to enable, to disable, or that are disabled.
#pragma once

#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/packets/tailoring.hpp"

namespace ilp {

namespace event_reporting {
inline constexpr std::uint8_t service = 5;
/// The report of an event has subtype 1 + its Severity.
inline constexpr std::uint8_t informative = 1, enable = 5, disable = 6, report_disabled = 7, disabled = 8;
}  // namespace event_reporting

/// Events by their StatusCode. `all`: the tailoring has no list, so every event is meant.
struct EventList {
  FixedVector<std::uint32_t, limits::max_event_list> ids;
  bool all = false;
};

/// TC[5,5] and [5,6]: `request_malformed` (a = offset), `capacity_exceeded`.
Status decode_event_list(const Tailoring& tailoring, std::span<const std::uint8_t> data, EventList& list);
/// TM[5,8].
void encode_disabled_events(const Tailoring& tailoring, std::span<const std::uint32_t> ids, ByteWriter& out);
/// TM[5,1] to [5,4]: the event and its auxiliary data.
void encode_event(const Tailoring& tailoring, std::uint32_t id, std::span<const std::uint8_t> auxiliary,
                  ByteWriter& out);

}  // namespace ilp
