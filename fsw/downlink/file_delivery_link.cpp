#include "fsw/downlink/file_delivery_link.hpp"

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

void FileDeliveryLink::take_in() {
  for (int i = 0; i < pdus_in_per_step; ++i) {
    std::size_t bytes = 0;
    const Status status = wiring_.router.receive(Channel::files, workspace_.pdu, bytes);
    if (status.is(StatusCode::not_ready)) return;
    ++wiring_.counts.pdus_in;
    if (status.ok()) {
      receive(std::span<const std::uint8_t>(workspace_.pdu).first(bytes));
    } else {
      ++wiring_.counts.rejected;
    }
  }
}

void FileDeliveryLink::receive(std::span<const std::uint8_t> bytes) {
  Pdu pdu;
  const Status decoded = cfdp::decode(bytes, pdu);
  if (!decoded.ok()) {
    ++wiring_.counts.rejected;
    // Rejections are reported at most once a minute.
    if (workspace_.contact_ns < workspace_.silent_until_ns) return;
    workspace_.silent_until_ns = workspace_.contact_ns + rejection_report_period_ns;
    return report(decoded);
  }
  const std::uint64_t own = wiring_.mission.cfdp_entity;
  const bool to_sender = pdu.kind == PduKind::finished || pdu.kind == PduKind::nak || pdu.kind == PduKind::keep_alive ||
                         (pdu.kind == PduKind::ack && !pdu.ack.of_finished);
  if (to_sender && pdu.header.source == own) return receive_as_sender(pdu);
  if (!to_sender && pdu.header.destination == own && workspace_.uplink.receive(pdu, workspace_.contact_ns)) return;
  ++wiring_.counts.ignored;
}

void FileDeliveryLink::receive_as_sender(const Pdu& pdu) {
  const cfdp::Header& header = pdu.header;
  for (Slot& slot : workspace_.slots) {
    const cfdp::Header& own = slot.sender.order().header;
    if (slot.waiting || own.sequence != header.sequence || own.destination != header.destination) continue;
    // A transaction that is over but not on disk yet is answered when it is.
    if (!slot.gone) slot.sender.receive(pdu, workspace_.contact_ns);
    return;
  }
  if (pdu.kind != PduKind::finished) {
    ++wiring_.counts.ignored;
    return;
  }
  for (const ClosedTransfer& closed : workspace_.closed) {
    if (closed.sequence != header.sequence || closed.destination != header.destination) continue;
    return answer_late(pdu, TransactionStatus::terminated);
  }
  answer_late(pdu, TransactionStatus::unrecognized);
}

void FileDeliveryLink::answer_late(const Pdu& finished, TransactionStatus status) {
  LateAcknowledgement late{finished.header, {true, finished.finished.condition, status}};
  late.header.toward_sender = false;
  late.header.crc = wiring_.mission.cfdp_pdu_crc;
  late.header.segment_metadata = false;
  late.header.record_boundaries = false;
  for (const LateAcknowledgement& waiting : workspace_.late) {
    const cfdp::Header& header = waiting.header;
    if (header.sequence == late.header.sequence && header.destination == late.header.destination) return;
  }
  // Without room it is dropped, and the receiver repeats it.
  if (!workspace_.late.push_back(late)) ++wiring_.counts.ignored;
}

Status FileDeliveryLink::send_pdu(std::size_t bytes) {
  ILP_TRY(wiring_.router.send(Channel::files, std::span<const std::uint8_t>(workspace_.pdu).first(bytes)));
  ++wiring_.counts.pdus_out;
  return {};
}

bool FileDeliveryLink::answer(const Pdu& pdu) {
  std::size_t bytes = 0;
  return !cfdp::encode(pdu, workspace_.pdu, bytes).ok() || send_pdu(bytes).ok();
}

bool FileDeliveryLink::send_late() {
  while (!workspace_.late.empty()) {
    Pdu pdu;
    pdu.header = workspace_.late[0].header;
    pdu.kind = PduKind::ack;
    pdu.ack = workspace_.late[0].ack;
    if (!answer(pdu)) return false;
    workspace_.late.erase(0);
  }
  return true;
}

bool FileDeliveryLink::send_uplink_answers() {
  // Every answer settles one PDU, so there are at most this many.
  constexpr std::size_t most = 4 * limits::max_uplinks + 2 * limits::max_closed_transfers;
  Pdu pdu;
  for (std::size_t i = 0; i < most && workspace_.uplink.next(pdu); ++i) {
    if (!answer(pdu)) return false;
    workspace_.uplink.sent(workspace_.contact_ns);
  }
  return true;
}

FileDeliveryLink::Slot* FileDeliveryLink::most_urgent(SendItem& item) {
  Slot* best = nullptr;
  for (Slot& slot : workspace_.slots) {
    if (slot.waiting || slot.gone || slot.dirty || slot.not_before_ns > workspace_.contact_ns) continue;
    SendItem wanted;
    if (best != nullptr && slot.priority >= best->priority) continue;
    if (!slot.sender.next(wanted)) continue;
    best = &slot;
    item = wanted;
  }
  return best;
}

Status FileDeliveryLink::send_item(Slot& slot, const SendItem& item) {
  Pdu pdu;
  slot.sender.build(item, pdu);
  if (item.kind == PduKind::file_data) {
    const std::span<std::uint8_t> bytes = std::span(workspace_.data).first(item.segment.end - item.segment.begin);
    const Status read = read_blob<TransferRecord>(wiring_.store, "data", slot.id, item.segment.begin, bytes);
    if (!read.ok()) {
      quarantine(slot, read, item.segment.begin);
      return {};
    }
    slot.faults = 0;
    pdu.file_data.bytes = bytes;
  }
  std::size_t bytes = 0;
  ILP_TRY(cfdp::encode(pdu, workspace_.pdu, bytes));
  ILP_TRY(send_pdu(bytes));
  slot.sender.sent(item, workspace_.contact_ns);
  return {};
}

void FileDeliveryLink::send() {
  if (!wiring_.router.contact() || !send_late() || !send_uplink_answers()) return;
  for (int i = 0; i < pdus_out_per_step; ++i) {
    SendItem item;
    Slot* slot = most_urgent(item);
    if (slot == nullptr || !send_item(*slot, item).ok()) return;
  }
}

}  // namespace ilp
