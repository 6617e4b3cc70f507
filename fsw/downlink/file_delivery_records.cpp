// FileDelivery's transfers on record.
#include "fsw/downlink/file_delivery.hpp"

namespace ilp {
namespace {

using cfdp::SendOutcome;
using cfdp::SendPhase;

/// A restart may repeat this many bytes of a file.
constexpr std::uint32_t unsaved_bytes = 256 * 1024;
constexpr TimeNs unsaved_ns = 10 * ns_per_s;
/// Transfers saved separately in a step in which they could not be saved together.
constexpr std::size_t most_saved_alone = 4;

std::span<std::uint8_t> bytes_of(cfdp::Piece* pieces, std::size_t count) {
  return {reinterpret_cast<std::uint8_t*>(pieces), count * sizeof(cfdp::Piece)};
}

}  // namespace

Status FileDelivery::adopt(const TransferRecord& record) {
  Slot slot;
  slot.id = record.id;
  slot.bytes = record.bytes;
  slot.priority = record.priority;
  slot.suspended = record.suspended;
  slot.attempts = record.attempts;
  if (record.state == TransferState::sending || record.state == TransferState::sent) {
    std::array<cfdp::Piece, limits::max_file_gaps> gaps{};
    std::size_t count = record.gaps.bytes / sizeof(cfdp::Piece);
    if (count > gaps.size()) count = 0;
    // Gaps that cannot be read will be requested again.
    const auto bytes = bytes_of(gaps.data(), count);
    if (count > 0 && !read_blob<TransferRecord>(store_, "gaps", record.id, 0, bytes).ok()) count = 0;
    const bool all_sent = record.state == TransferState::sent;
    slot.sender.resume(order_of(record), settings(), record.progress, all_sent, std::span(gaps).first(count));
    if (slot.suspended) slot.sender.suspend();
    slot.waiting = false;
    slot.saved_progress = slot.sender.progress();
    slot.saved_phase = static_cast<std::uint8_t>(slot.sender.phase());
    slot.saved_ns = contact_ns_;
  }
  ILP_ASSERT(slots_.push_back(slot), slots_.size());
  return {};
}

Status FileDelivery::drop_damaged(std::int64_t id) {
  StepTransaction transaction(store_, checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(erase<TransferRecord>(store_, id));
  return transaction.commit();
}

Status FileDelivery::adopt_new() {
  TransferRecord record;
  while (!slots_.full()) {
    const Status found = next(store_, adopted_through_, record);
    if (found.is(StatusCode::not_found)) return {};
    if (found.is(StatusCode::record_damaged)) {
      ILP_TRY(drop_damaged(found.a));
      adopted_through_ = found.a;
      report({StatusCode::transfer_given_up, 0, static_cast<std::int64_t>(found.code)});
      continue;
    }
    ILP_TRY(found);
    if (record.state != TransferState::delivered) ILP_TRY(adopt(record));
    adopted_through_ = record.id;
  }
  return {};
}

Status FileDelivery::find(Slot& slot, TransferRecord& record, bool& there) {
  const Status found = get(store_, slot.id, record);
  there = found.ok();
  // A newer file of its name has replaced it.
  if (found.is(StatusCode::not_found)) slot.gone = true;
  return found.is(StatusCode::not_found) ? Status{} : found;
}

void FileDelivery::mark_changes(Slot& slot) {
  const std::uint32_t progress = slot.sender.progress();
  const bool other_phase = slot.saved_phase != static_cast<std::uint8_t>(slot.sender.phase());
  const bool much = progress - slot.saved_progress >= unsaved_bytes;
  const bool old = progress != slot.saved_progress && contact_ns_ - slot.saved_ns >= unsaved_ns;
  slot.dirty = slot.dirty || other_phase || much || old;
}

Status FileDelivery::save(Slot& slot) {
  if (slot.lost) {
    const Status erased = erase<TransferRecord>(store_, slot.id);
    return erased.is(StatusCode::not_found) ? Status{} : erased;
  }
  TransferRecord record;
  bool there = false;
  ILP_TRY(find(slot, record, there));
  if (!there) return {};
  const cfdp::Sender& sender = slot.sender;
  const SendOutcome outcome = slot.waiting ? SendOutcome::cancelled : sender.outcome();
  record.wish = TransferWish::none;
  record.suspended = slot.suspended;
  if (slot.gone && outcome == SendOutcome::cancelled) {
    return erase<TransferRecord>(store_, slot.id);
  }
  if (!slot.waiting) {
    record.sequence = static_cast<std::int64_t>(sender.order().header.sequence);
    record.progress = sender.progress();
    record.condition = static_cast<std::uint8_t>(sender.condition());
    record.resent_bytes = sender.counts().resent_bytes;
    record.state = sender.phase() == SendPhase::data ? TransferState::sending : TransferState::sent;
    record.gaps.bytes = static_cast<std::uint32_t>(sender.gaps().size() * sizeof(cfdp::Piece));
  }
  if (slot.gone && outcome == SendOutcome::delivered) {
    record.state = TransferState::delivered;
    record.delivered_ns = clock_.now();
    record.data.bytes = 0;
    record.gaps.bytes = 0;
  } else if (slot.gone) {
    record.state = TransferState::waiting;
    record.attempts = slot.attempts + 1;
    record.progress = 0;
    record.gaps.bytes = 0;
  }
  ILP_TRY(amend(store_, record));
  if (record.gaps.bytes == 0) return {};
  cfdp::PieceList gaps = sender.gaps();
  return write_blob<TransferRecord>(store_, "gaps", record.id, 0, bytes_of(gaps.data(), gaps.size()));
}

Status FileDelivery::save() {
  const Uplink::Open uplinks = uplink_.open();
  state_dirty_ = state_dirty_ || uplinks != state_.uplinks;
  state_.uplinks = uplinks;
  bool any = state_dirty_;
  for (const Slot& slot : slots_) any = any || slot.dirty;
  if (!any) return {};
  const Status together = save_checkpoint_and({slots_.data(), slots_.size()});
  if (together.ok()) return {};
  if (state_dirty_) ILP_TRY(save_checkpoint_and({}));
  // A transfer that cannot be saved must not delay the others.
  std::size_t tried = 0;
  bool any_saved = false;
  for (std::size_t i = 0; i < slots_.size() && tried < most_saved_alone; ++i) {
    save_from_ = (save_from_ + 1) % slots_.size();
    Slot& slot = slots_[save_from_];
    if (!slot.dirty) continue;
    ++tried;
    const Status alone = save_checkpoint_and({&slot, 1});
    any_saved = any_saved || alone.ok();
    if (!alone.ok() && !is_transient(alone)) set_aside(slot, alone);
  }
  // After a fault the executive would make the others wait, too.
  return any_saved ? Status{} : together;
}

Status FileDelivery::save_checkpoint_and(std::span<Slot> slots) {
  StepTransaction transaction(store_, checkpoint);
  ILP_TRY(transaction.begin());
  for (Slot& slot : slots) {
    if (slot.dirty) ILP_TRY(save(slot));
  }
  // The progress of a transfer is in its record.
  ILP_TRY(state_dirty_ ? transaction.commit(cursor_, state_, cursor_) : transaction.commit());
  state_dirty_ = false;
  for (Slot& slot : slots) {
    if (!slot.dirty) continue;
    slot.dirty = false;
    slot.saved_progress = slot.sender.progress();
    slot.saved_phase = static_cast<std::uint8_t>(slot.sender.phase());
    slot.saved_ns = contact_ns_;
  }
  return {};
}

}  // namespace ilp
