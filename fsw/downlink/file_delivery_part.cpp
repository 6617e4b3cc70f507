#include "fsw/downlink/file_delivery_part.hpp"

#include <algorithm>

#include "fsw/base/text.hpp"

namespace ilp {
namespace {

/// Faults of the store for one transfer until it is abandoned: faults that may pass, and permanent ones.
constexpr std::uint32_t most_passing_faults = 10;
constexpr std::uint32_t most_lasting_faults = 3;

}  // namespace

cfdp::SenderSettings FileDeliveryPart::settings() const {
  cfdp::SenderSettings settings;
  settings.segment_bytes = wiring_.mission.cfdp_segment_bytes;
  settings.metadata_copies = wiring_.mission.cfdp_metadata_copies;
  settings.timer_ns = ns_from_seconds(wiring_.mission.cfdp_timer_s);
  settings.timer_limit = wiring_.mission.cfdp_timer_limit;
  settings.rest_ns = ns_from_seconds(wiring_.mission.cfdp_rest_s);
  settings.prompt_ns = ns_from_seconds(wiring_.mission.cfdp_prompt_s);
  return settings;
}

cfdp::SendOrder FileDeliveryPart::order_of(const TransferRecord& record) const {
  cfdp::SendOrder order;
  order.header.crc = wiring_.mission.cfdp_pdu_crc;
  unsigned octets = wiring_.mission.cfdp_sequence_octets;
  // A transaction that began with longer numbers keeps them.
  while (octets < 8 && (record.sequence >> (8 * octets)) != 0) octets *= 2;
  order.header.sequence_length = static_cast<std::uint8_t>(octets);
  order.header.source = wiring_.mission.cfdp_entity;
  order.header.sequence = static_cast<std::uint64_t>(record.sequence);
  order.header.destination = static_cast<std::uint64_t>(record.destination);
  copy_text(order.name, record.name);
  order.file_bytes = record.bytes;
  order.checksum_type = static_cast<std::uint8_t>(record.checksum_type);
  order.checksum = record.checksum;
  return order;
}

void FileDeliveryPart::cancel(Slot& slot, const TransferRecord& record) {
  if (slot.waiting) return close(slot);
  cfdp::FileChecksum checksum(record.checksum_type);
  std::uint32_t value = 0;
  bool whole = true;
  for (std::uint32_t at = 0; whole && at < slot.sender.progress();) {
    const std::uint32_t left = slot.sender.progress() - at;
    const std::span<std::uint8_t> segment =
        std::span(workspace_.data).first(left < workspace_.data.size() ? left : workspace_.data.size());
    whole = read_blob<TransferRecord>(wiring_.store, "data", slot.id, at, segment).ok();
    checksum.add(segment);
    at += static_cast<std::uint32_t>(segment.size());
  }
  // The receiver discards the file whatever the checksum is, so an unreadable file has none.
  if (whole) value = checksum.value();
  slot.not_before_ns = 0;
  slot.sender.cancel(value, workspace_.contact_ns);
  slot.suspended = false;
}

void FileDeliveryPart::quarantine(Slot& slot, const Status& fault, std::int64_t at) {
  if (slot.gone) return;
  const std::uint32_t doublings = slot.faults < most_doublings ? slot.faults : most_doublings;
  slot.not_before_ns = workspace_.contact_ns + (ns_from_seconds(wiring_.mission.cfdp_rest_s) << doublings);
  if (slot.faults++ == 0) report({StatusCode::transfer_damaged, sequence_of(slot), at});
  const bool abandoned = slot.faults >= (is_transient(fault) ? most_passing_faults : most_lasting_faults);
  if (!abandoned) return;
  report({StatusCode::transfer_given_up, sequence_of(slot), static_cast<std::int64_t>(fault.code)});
  slot.not_before_ns = 0;
  slot.dirty = true;
  TransferRecord record;
  slot.lost = !get(wiring_.store, slot.id, record).ok();
  // Without its record the content of a transaction is not known, so nothing is reported.
  if (slot.waiting || slot.lost) return close(slot);
  slot.sender.cancel(0, workspace_.contact_ns);
  slot.suspended = false;
}

void FileDeliveryPart::close(Slot& slot) {
  slot.dirty = true;
  slot.gone = true;
}

std::int64_t FileDeliveryPart::sequence_of(const Slot& slot) {
  return static_cast<std::int64_t>(slot.sender.order().header.sequence);
}

void FileDeliveryPart::report(Status event) {
  if (!workspace_.events.push_back(event)) ++wiring_.counts.events_lost;
}

}  // namespace ilp
