#include "fsw/packets/telemetry_writer.hpp"

namespace ilp {

TelemetryWriter::TelemetryWriter(PacketRouter& router, Clock& clock, const MissionParameters& mission)
    : router_(router), clock_(clock), mission_(mission), settings_(mission) {}

void TelemetryWriter::configure() {
  settings_ = LinkSettings(mission_);
  counters_ = {};
  uses_ = 0;
  sequence_ = 0;
}

std::uint16_t TelemetryWriter::count(std::uint8_t service, std::uint8_t subtype, std::uint16_t destination) {
  const std::uint32_t key = (std::uint32_t{destination} << 16U) | (std::uint32_t{service} << 8U) | subtype;
  Counter* found = counters_.data();
  for (Counter& counter : counters_) {
    if (counter.used != 0 && counter.key == key) {
      found = &counter;
      break;
    }
    // The counter that was unused for longest is replaced.
    if (counter.used < found->used) found = &counter;
  }
  if (found->used == 0 || found->key != key) *found = {key, 0, 0};
  found->used = ++uses_;
  return found->next++;
}

void TelemetryWriter::push(std::span<const std::uint8_t> packet) {
  while (!ring_.push(packet)) {  // bound: the packets in the ring; each turn drops one
    std::size_t bytes = 0;
    // The packet in next_ is older than the ring's.
    if (next_bytes_ != 0) {
      next_bytes_ = 0;
    } else if (!ring_.pop(next_, bytes).ok()) {
      return;
    }
    ++lost_;
    --waiting_;
  }
  ++waiting_;
}

Status TelemetryWriter::report(std::uint8_t service, std::uint8_t subtype, std::uint16_t destination,
                               std::span<const std::uint8_t> data) {
  if (!router_.present()) return {};
  Telemetry telemetry;
  telemetry.primary.apid = settings_.apid;
  telemetry.primary.sequence_count = sequence_;
  telemetry.service = service;
  telemetry.subtype = subtype;
  telemetry.destination = destination;
  telemetry.time = now();
  telemetry.data = data;
  std::array<std::uint8_t, limits::max_report_bytes> packet;
  std::size_t bytes = 0;
  // The counters advance only for a packet that exists.
  ILP_TRY(encode_telemetry(telemetry, settings_.tailoring.time, packet, bytes));
  telemetry.counter = count(service, subtype, destination);
  ILP_TRY(encode_telemetry(telemetry, settings_.tailoring.time, packet, bytes));
  sequence_ = static_cast<std::uint16_t>((sequence_ + 1U) % sequence_counts);
  push({packet.data(), bytes});
  flush();
  return {};
}

void TelemetryWriter::flush() {
  // Bounded by the waiting packets.
  while (waiting_ != 0) {
    if (next_bytes_ == 0 && !ring_.pop(next_, next_bytes_).ok()) return;
    if (!router_.send(Channel::commands, {next_.data(), next_bytes_}).ok()) return;
    next_bytes_ = 0;
    --waiting_;
    ++sent_;
  }
}

}  // namespace ilp
