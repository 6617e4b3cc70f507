#include "fsw/downlink/file_delivery_records.hpp"

#include "fsw/downlink/file_delivery.hpp"
#include "fsw/shared/find.hpp"

namespace ilp {
namespace {

using cfdp::SendOutcome;
using cfdp::SendPhase;

/// A restart may repeat this many bytes of a file.
constexpr std::uint32_t unsaved_bytes = 256 * 1024;
constexpr TimeNs unsaved_ns = 10 * ns_per_s;
/// Transfers saved separately in a step in which they could not be saved together.
constexpr std::size_t most_saved_alone = 4;

std::span<std::uint8_t> bytes_of(cfdp::Segment* segments, std::size_t count) {
  return {reinterpret_cast<std::uint8_t*>(segments), count * sizeof(cfdp::Segment)};
}

}  // namespace

Status FileDeliveryRecords::adopt(const TransferRecord& record) {
  Slot slot;
  slot.id = record.id;
  slot.bytes = record.bytes;
  slot.priority = record.priority;
  slot.suspended = record.suspended;
  slot.attempts = record.attempts;
  if (record.state == TransferState::sending || record.state == TransferState::sent) {
    std::array<cfdp::Segment, limits::max_file_gaps> gaps{};
    std::size_t count = record.gaps.bytes / sizeof(cfdp::Segment);
    if (count > gaps.size()) count = 0;
    // Gaps that cannot be read will be requested again.
    const auto bytes = bytes_of(gaps.data(), count);
    if (count > 0 && !read_blob<TransferRecord>(wiring_.store, "gaps", record.id, 0, bytes).ok()) count = 0;
    const bool all_sent = record.state == TransferState::sent;
    slot.sender.resume(order_of(record), settings(), record.progress, all_sent, std::span(gaps).first(count));
    if (slot.suspended) slot.sender.suspend();
    slot.waiting = false;
    slot.saved_progress = slot.sender.progress();
    slot.saved_phase = static_cast<std::uint8_t>(slot.sender.phase());
    slot.saved_ns = workspace_.contact_ns;
  }
  ILP_ASSERT(workspace_.slots.push_back(slot), workspace_.slots.size());
  return {};
}

Status FileDeliveryRecords::drop_damaged(std::int64_t id) {
  StepTransaction transaction(wiring_.store, FileDelivery::checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(erase<TransferRecord>(wiring_.store, id));
  return transaction.commit();
}

Status FileDeliveryRecords::adopt_new() {
  TransferRecord record;
  while (!workspace_.slots.full()) {
    ILP_TAKE(const Found found, find_next(wiring_.store, work_.adopted_through, record));
    if (found == Found::nothing) return {};
    if (found == Found::damaged) {
      ILP_TRY(drop_damaged(record.id));
      report({StatusCode::transfer_given_up, 0, static_cast<std::int64_t>(StatusCode::record_damaged)});
    } else if (record.state != TransferState::delivered)
      ILP_TRY(adopt(record));
    work_.adopted_through = record.id;
  }
  return {};
}

Result<bool> FileDeliveryRecords::find(Slot& slot, TransferRecord& record) {
  const Status found = get(wiring_.store, slot.id, record);
  if (found.ok()) return true;
  if (!found.is(StatusCode::not_found)) return found;
  // A newer file of its name has replaced it.
  slot.gone = true;
  return false;
}

void FileDeliveryRecords::mark_changes(Slot& slot) {
  const std::uint32_t progress = slot.sender.progress();
  const bool other_phase = slot.saved_phase != static_cast<std::uint8_t>(slot.sender.phase());
  const bool much = progress - slot.saved_progress >= unsaved_bytes;
  const bool old = progress != slot.saved_progress && workspace_.contact_ns - slot.saved_ns >= unsaved_ns;
  slot.dirty = slot.dirty || other_phase || much || old;
}

Status FileDeliveryRecords::save(Slot& slot) {
  if (slot.lost) {
    const Status erased = erase<TransferRecord>(wiring_.store, slot.id);
    return erased.is(StatusCode::not_found) ? Status{} : erased;
  }
  TransferRecord record;
  ILP_TAKE(const bool there, find(slot, record));
  if (!there) return {};
  const cfdp::Sender& sender = slot.sender;
  const SendOutcome outcome = slot.waiting ? SendOutcome::cancelled : sender.outcome();
  record.wish = TransferWish::none;
  record.suspended = slot.suspended;
  if (slot.gone && outcome == SendOutcome::cancelled) {
    return erase<TransferRecord>(wiring_.store, slot.id);
  }
  if (!slot.waiting) {
    record.sequence = static_cast<std::int64_t>(sender.order().header.sequence);
    record.progress = sender.progress();
    record.condition = static_cast<std::uint8_t>(sender.condition());
    record.resent_bytes = sender.counts().resent_bytes;
    record.state = sender.phase() == SendPhase::data ? TransferState::sending : TransferState::sent;
    record.gaps.bytes = static_cast<std::uint32_t>(sender.gaps().size() * sizeof(cfdp::Segment));
  }
  if (slot.gone && outcome == SendOutcome::delivered) {
    record.state = TransferState::delivered;
    record.delivered_ns = wiring_.clock.now();
    record.data.bytes = 0;
    record.gaps.bytes = 0;
  } else if (slot.gone) {
    record.state = TransferState::waiting;
    record.attempts = slot.attempts + 1;
    record.progress = 0;
    record.gaps.bytes = 0;
  }
  ILP_TRY(amend(wiring_.store, record));
  if (record.gaps.bytes == 0) return {};
  cfdp::SegmentList gaps = sender.gaps();
  return write_blob<TransferRecord>(wiring_.store, "gaps", record.id, 0, bytes_of(gaps.data(), gaps.size()));
}

Status FileDeliveryRecords::save() {
  const Uplink::Open uplinks = workspace_.uplink.open();
  work_.state_dirty = work_.state_dirty || uplinks != state_.uplinks;
  state_.uplinks = uplinks;
  bool any = work_.state_dirty;
  for (const Slot& slot : workspace_.slots) any = any || slot.dirty;
  if (!any) return {};
  const Status together = save_checkpoint_and({workspace_.slots.data(), workspace_.slots.size()});
  if (together.ok()) return {};
  if (work_.state_dirty) ILP_TRY(save_checkpoint_and({}));
  // A transfer that cannot be saved must not delay the others.
  std::size_t tried = 0;
  bool any_saved = false;
  for (std::size_t i = 0; i < workspace_.slots.size() && tried < most_saved_alone; ++i) {
    workspace_.save_from = (workspace_.save_from + 1) % workspace_.slots.size();
    Slot& slot = workspace_.slots[workspace_.save_from];
    if (!slot.dirty) continue;
    ++tried;
    const Status alone = save_checkpoint_and({&slot, 1});
    any_saved = any_saved || alone.ok();
    if (!alone.ok() && !is_transient(alone)) quarantine(slot, alone);
  }
  // After a fault the executive would make the others wait, too.
  return any_saved ? Status{} : together;
}

Status FileDeliveryRecords::save_checkpoint_and(std::span<Slot> slots) {
  StepTransaction transaction(wiring_.store, FileDelivery::checkpoint);
  ILP_TRY(transaction.begin());
  for (Slot& slot : slots) {
    if (slot.dirty) ILP_TRY(save(slot));
  }
  // The progress of a transfer is in its record.
  ILP_TRY(work_.state_dirty ? transaction.commit(cursor_, state_, cursor_) : transaction.commit());
  work_.state_dirty = false;
  for (Slot& slot : slots) {
    if (!slot.dirty) continue;
    slot.dirty = false;
    slot.saved_progress = slot.sender.progress();
    slot.saved_phase = static_cast<std::uint8_t>(slot.sender.phase());
    slot.saved_ns = workspace_.contact_ns;
  }
  return {};
}

}  // namespace ilp
