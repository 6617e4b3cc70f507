#include "fsw/packets/service_events.hpp"

namespace ilp {

Status decode_event_list(const Tailoring& tailoring, std::span<const std::uint8_t> data, EventList& list) {
  list = {};
  ByteReader in(data);
  const auto malformed = [&] { return Status{StatusCode::request_malformed, static_cast<std::int64_t>(in.offset())}; };
  list.all = tailoring.events_one_and_all;
  if (list.all) return in.left() == 0 ? Status{} : malformed();
  const std::uint32_t count = read_count(tailoring.event_count, in);
  if (!in.ok() || count == 0) return malformed();
  if (count > limits::max_event_list) {
    return {StatusCode::capacity_exceeded, count, static_cast<std::int64_t>(limits::max_event_list)};
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto id = static_cast<std::uint32_t>(in.number(tailoring.event_id));
    if (!in.ok()) return malformed();
    static_cast<void>(list.ids.push_back(id));
  }
  return in.left() == 0 ? Status{} : malformed();
}

void encode_disabled_events(const Tailoring& tailoring, std::span<const std::uint32_t> ids, ByteWriter& out) {
  const std::uint8_t octets = tailoring.event_count == 0 ? 2 : tailoring.event_count;
  write_count(octets, ids.size(), out);
  for (const std::uint32_t id : ids) out.number(id, tailoring.event_id);
}

void encode_event(const Tailoring& tailoring, std::uint32_t id, std::span<const std::uint8_t> auxiliary,
                  ByteWriter& out) {
  out.number(id, tailoring.event_id);
  out.put(auxiliary);
}

}  // namespace ilp
