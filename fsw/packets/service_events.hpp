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

struct EventList {
  FixedVector<std::uint32_t, limits::max_event_list> ids;  ///< numbers of StatusCode
  bool all = false;                                        ///< every event: the tailoring's telecommand has no list
};

/// Decodes TC[5,5] or [5,6]. Returns `request_malformed` (first value: offset in `data`) if the list is cut, is empty
/// or is followed by further octets, and `capacity_exceeded` if it is too long.
Status decode_event_list(const Tailoring& tailoring, std::span<const std::uint8_t> data, EventList& list);
/// Appends the data of TM[5,8].
void encode_disabled_events(const Tailoring& tailoring, std::span<const std::uint32_t> ids, ByteWriter& out);
/// Appends the data of TM[5,1] to [5,4]: event and auxiliary data.
void encode_event(const Tailoring& tailoring, std::uint32_t id, std::span<const std::uint8_t> auxiliary,
                  ByteWriter& out);

}  // namespace ilp
