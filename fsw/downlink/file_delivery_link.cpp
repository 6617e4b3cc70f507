// FileDelivery's traffic with the router.
#include "fsw/downlink/file_delivery.hpp"

namespace ilp {
namespace {

using cfdp::Pdu;
using cfdp::PduKind;
using cfdp::SendItem;
using cfdp::TransactionStatus;

constexpr int pdus_in_per_step = 128;
constexpr int pdus_out_per_step = 512;
constexpr TimeNs rejection_report_period_ns = 60 * ns_per_s;

}  // namespace

void FileDelivery::take_in() {
  for (int i = 0; i < pdus_in_per_step; ++i) {
    std::size_t bytes = 0;
    const Status status = router_.receive(Channel::files, pdu_, bytes);
    if (status.is(StatusCode::not_ready)) return;
    ++counts_.pdus_in;
    if (status.ok()) {
      hear(std::span<const std::uint8_t>(pdu_).first(bytes));
    } else {
      ++counts_.rejected;
    }
  }
}

void FileDelivery::hear(std::span<const std::uint8_t> bytes) {
  Pdu pdu;
  const Status decoded = cfdp::decode(bytes, pdu);
  if (!decoded.ok()) {
    ++counts_.rejected;
    // Rejections are reported at most once a minute.
    const bool told = rejection_reported_ns_ >= 0 && contact_ns_ - rejection_reported_ns_ < rejection_report_period_ns;
    if (!told) {
      rejection_reported_ns_ = contact_ns_;
      report(decoded);
    }
    return;
  }
  const std::uint64_t own = mission_.cfdp_entity;
  const bool to_sender = pdu.kind == PduKind::finished || pdu.kind == PduKind::nak || pdu.kind == PduKind::keep_alive ||
                         (pdu.kind == PduKind::ack && !pdu.ack.of_finished);
  if (to_sender && pdu.header.source == own) return hear_as_sender(pdu);
  if (!to_sender && pdu.header.destination == own && uplink_.hear(pdu, contact_ns_)) return;
  ++counts_.ignored;
}

void FileDelivery::hear_as_sender(const Pdu& pdu) {
  const cfdp::Header& header = pdu.header;
  for (Slot& slot : slots_) {
    const cfdp::Header& own = slot.sender.order().header;
    if (slot.waiting || own.sequence != header.sequence || own.destination != header.destination) continue;
    // A transaction that is over but not on disk yet is answered when it is.
    if (!slot.gone) slot.sender.receive(pdu, contact_ns_);
    return;
  }
  if (pdu.kind != PduKind::finished) {
    ++counts_.ignored;
    return;
  }
  for (const Closed& closed : closed_) {
    if (closed.sequence != header.sequence || closed.destination != header.destination) continue;
    return answer_late(pdu, TransactionStatus::terminated);
  }
  answer_late(pdu, TransactionStatus::unrecognized);
}

void FileDelivery::answer_late(const Pdu& finished, TransactionStatus status) {
  LateAcknowledgement late{finished.header, {true, finished.finished.condition, status}};
  late.header.toward_sender = false;
  late.header.crc = mission_.cfdp_pdu_crc;
  late.header.segment_metadata = false;
  late.header.record_boundaries = false;
  for (const LateAcknowledgement& waiting : late_) {
    const cfdp::Header& header = waiting.header;
    if (header.sequence == late.header.sequence && header.destination == late.header.destination) return;
  }
  // Without room it is dropped, and the receiver repeats it.
  if (!late_.push_back(late)) ++counts_.ignored;
}

bool FileDelivery::send_late() {
  while (!late_.empty()) {
    Pdu pdu;
    pdu.header = late_[0].header;
    pdu.kind = PduKind::ack;
    pdu.ack = late_[0].ack;
    std::size_t bytes = 0;
    if (cfdp::encode(pdu, pdu_, bytes).ok()) {
      if (!router_.send(Channel::files, std::span<const std::uint8_t>(pdu_).first(bytes)).ok()) return false;
      ++counts_.pdus_out;
    }
    for (std::size_t i = 0; i + 1 < late_.size(); ++i) late_[i] = late_[i + 1];
    late_.pop_back();
  }
  return true;
}

bool FileDelivery::send_uplink_answers() {
  // Every answer settles one PDU, so there are at most this many.
  constexpr std::size_t most = 4 * limits::max_uplinks + 2 * limits::max_closed_transfers;
  Pdu pdu;
  for (std::size_t i = 0; i < most && uplink_.next(pdu); ++i) {
    std::size_t bytes = 0;
    if (cfdp::encode(pdu, pdu_, bytes).ok()) {
      if (!router_.send(Channel::files, std::span<const std::uint8_t>(pdu_).first(bytes)).ok()) return false;
      ++counts_.pdus_out;
    }
    uplink_.sent(contact_ns_);
  }
  return true;
}

FileDelivery::Slot* FileDelivery::most_urgent(SendItem& item) {
  Slot* best = nullptr;
  for (Slot& slot : slots_) {
    if (slot.waiting || slot.gone || slot.dirty || slot.not_before_ns > contact_ns_) continue;
    SendItem wanted;
    if (best != nullptr && slot.priority >= best->priority) continue;
    if (!slot.sender.next(wanted)) continue;
    best = &slot;
    item = wanted;
  }
  return best;
}

Status FileDelivery::send_item(Slot& slot, const SendItem& item) {
  Pdu pdu;
  slot.sender.build(item, pdu);
  if (item.kind == PduKind::file_data) {
    const std::span<std::uint8_t> bytes = std::span(data_).first(item.piece.end - item.piece.begin);
    const Status read = read_blob<TransferRecord>(store_, "data", slot.id, item.piece.begin, bytes);
    if (!read.ok()) {
      set_aside(slot, read, item.piece.begin);
      return {};
    }
    slot.faults = 0;
    pdu.file_data.bytes = bytes;
  }
  std::size_t bytes = 0;
  ILP_TRY(cfdp::encode(pdu, pdu_, bytes));
  ILP_TRY(router_.send(Channel::files, std::span<const std::uint8_t>(pdu_).first(bytes)));
  ++counts_.pdus_out;
  slot.sender.sent(item, contact_ns_);
  return {};
}

void FileDelivery::send() {
  if (!router_.contact() || !send_late() || !send_uplink_answers()) return;
  for (int i = 0; i < pdus_out_per_step; ++i) {
    SendItem item;
    Slot* slot = most_urgent(item);
    if (slot == nullptr || !send_item(*slot, item).ok()) return;
  }
}

}  // namespace ilp
