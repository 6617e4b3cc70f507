#include "tests/support/loopback_link.hpp"

#include <algorithm>

namespace ilp {

Status LoopbackDirection::put(std::span<const std::uint8_t> packet, TimeNs due) {
  if (packet.size() > packet_bytes) {
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(packet.size()),
            static_cast<std::int64_t>(packet_bytes)};
  }
  const auto slot = std::find_if(slots_.begin(), slots_.end(), [](const Slot& s) { return !s.used; });
  if (slot == slots_.end()) return StatusCode::not_ready;
  std::copy(packet.begin(), packet.end(), slot->bytes.begin());
  slot->size = packet.size();
  slot->due = due;
  slot->number = next_++;
  slot->used = true;
  return {};
}

Status LoopbackDirection::take(std::span<std::uint8_t> out, std::size_t& bytes, TimeNs now) {
  bytes = 0;
  Slot* first = nullptr;
  for (Slot& slot : slots_) {
    if (!slot.used || slot.due > now) continue;
    if (first == nullptr || slot.due < first->due || (slot.due == first->due && slot.number < first->number)) {
      first = &slot;
    }
  }
  if (first == nullptr) return StatusCode::not_ready;
  first->used = false;
  if (first->size > out.size()) {
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(first->size),
            static_cast<std::int64_t>(out.size())};
  }
  std::copy_n(first->bytes.begin(), first->size, out.begin());
  bytes = first->size;
  return {};
}

LoopbackEnd::LoopbackEnd(LoopbackDirection& in, LoopbackDirection& out, Clock& clock, const LoopbackFaults& faults,
                         std::uint64_t stream)
    : in_(in), out_(out), clock_(clock), faults_(faults), rng_(faults.seed, stream) {}

Status LoopbackEnd::receive(std::span<std::uint8_t> buffer, std::size_t& bytes) {
  return in_.take(buffer, bytes, clock_.now());
}

bool LoopbackEnd::outage(TimeNs now) const {
  return faults_.outage_period_ns > 0 &&
         now % faults_.outage_period_ns >= faults_.outage_period_ns - faults_.outage_length_ns;
}

TimeNs LoopbackEnd::due(TimeNs now) {
  return now + faults_.delay_ns + (rng_.uniform() < faults_.reordering ? faults_.late_ns : 0);
}

Status LoopbackEnd::send(std::span<const std::uint8_t> packet) {
  const TimeNs now = clock_.now();
  // The number of draws is constant, so that one fault does not shift the others.
  const bool lost = rng_.uniform() < faults_.loss;
  const bool twice = rng_.uniform() < faults_.duplication;
  const TimeNs first = due(now), second = due(now);
  if (lost || outage(now)) {
    ++lost_;
    return {};
  }
  ILP_TRY(out_.put(packet, first));
  // If the queue has no room the copy is lost, which does not matter.
  if (twice) static_cast<void>(out_.put(packet, second));
  return {};
}

LoopbackLink::LoopbackLink(Clock& clock, const LoopbackFaults& faults)
    : faults_(faults), board_(up_, down_, clock, faults_, 1), ground_(down_, up_, clock, faults_, 2) {}

}  // namespace ilp
