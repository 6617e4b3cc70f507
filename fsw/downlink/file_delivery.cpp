#include "fsw/downlink/file_delivery.hpp"

#include "fsw/base/text.hpp"
#include "fsw/packets/cfdp_checksum.hpp"

namespace ilp {
namespace {

using cfdp::Pdu;
using cfdp::PduKind;
using cfdp::SendItem;
using cfdp::SendOutcome;
using cfdp::SendPhase;

/// Requests of the ground are searched once in this many steps.
constexpr std::uint32_t wish_period_steps = 5;
/// A restart may repeat this many bytes of a file.
constexpr std::uint32_t unsaved_bytes = 256 * 1024;
constexpr TimeNs unsaved_ns = 10 * ns_per_s;
/// Longer gaps between two steps are a freeze, in which nothing could be received.
constexpr TimeNs longest_step_ns = ns_per_s;
constexpr std::uint32_t most_doublings = 6;
/// Faults of the store for one transfer until it is abandoned: faults that may pass, and permanent ones.
constexpr std::uint32_t most_passing_faults = 10;
constexpr std::uint32_t most_lasting_faults = 3;
/// Transfers saved separately in a step in which they could not be saved together.
constexpr std::size_t most_saved_alone = 4;

std::span<std::uint8_t> bytes_of(cfdp::Piece* pieces, std::size_t count) {
  return {reinterpret_cast<std::uint8_t*>(pieces), count * sizeof(cfdp::Piece)};
}

}  // namespace

constexpr CheckpointForm FileDelivery::checkpoint = checkpoint_form<State>(component_id);

FileDelivery::FileDelivery(Tables store, PacketRouter& router, Clock& clock, const MissionParameters& mission)
    : store_(store), router_(router), clock_(clock), mission_(mission), uplink_(store, clock, mission) {}

cfdp::SenderSettings FileDelivery::settings() const {
  cfdp::SenderSettings settings;
  settings.segment_bytes = mission_.cfdp_segment_bytes;
  settings.metadata_copies = mission_.cfdp_metadata_copies;
  settings.timer_ns = ns_from_seconds(mission_.cfdp_timer_s);
  settings.timer_limit = mission_.cfdp_timer_limit;
  settings.rest_ns = ns_from_seconds(mission_.cfdp_rest_s);
  settings.prompt_ns = ns_from_seconds(mission_.cfdp_prompt_s);
  return settings;
}

cfdp::SendOrder FileDelivery::order_of(const TransferRecord& record) const {
  cfdp::SendOrder order;
  order.header.crc = mission_.cfdp_pdu_crc;
  unsigned octets = mission_.cfdp_sequence_octets;
  // A transaction that began with longer numbers keeps them.
  while (octets < 8 && (record.sequence >> (8 * octets)) != 0) octets *= 2;
  order.header.sequence_length = static_cast<std::uint8_t>(octets);
  order.header.source = mission_.cfdp_entity;
  order.header.sequence = static_cast<std::uint64_t>(record.sequence);
  order.header.destination = static_cast<std::uint64_t>(record.destination);
  copy_text(order.name, record.name);
  order.file_bytes = record.bytes;
  order.checksum_type = static_cast<std::uint8_t>(record.checksum_type);
  order.checksum = record.checksum;
  return order;
}

Status FileDelivery::restore() {
  slots_.clear();
  late_.clear();
  closed_ = {};
  adopted_through_ = 0;
  last_ns_ = clock_.now();
  state_dirty_ = false;
  const Status loaded = restore_checkpoint(store_, checkpoint, cursor_, state_);
  if (!restored(loaded)) return loaded;
  uplink_.restore(state_.uplinks, contact_ns_);
  return loaded;
}

Status FileDelivery::adopt(const TransferRecord& record) {
  Slot slot;
  slot.id = record.id;
  slot.priority = record.priority;
  slot.suspended = record.suspended != 0;
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

void FileDelivery::cancel(Slot& slot, const TransferRecord& record) {
  if (slot.waiting) return close(slot);
  cfdp::FileChecksum checksum(record.checksum_type);
  std::uint32_t value = 0;
  bool whole = true;
  for (std::uint32_t at = 0; whole && at < slot.sender.progress();) {
    const std::uint32_t left = slot.sender.progress() - at;
    const std::span<std::uint8_t> piece = std::span(data_).first(left < data_.size() ? left : data_.size());
    whole = read_blob<TransferRecord>(store_, "data", slot.id, at, piece).ok();
    checksum.add(piece);
    at += static_cast<std::uint32_t>(piece.size());
  }
  // The receiver discards the file whatever the checksum is, so an unreadable file has none.
  if (whole) value = checksum.value();
  slot.not_before_ns = 0;
  slot.sender.cancel(value, contact_ns_);
  slot.suspended = false;
}

void FileDelivery::set_aside(Slot& slot, const Status& fault, std::int64_t at) {
  if (slot.gone) return;
  const std::uint32_t doublings = slot.faults < most_doublings ? slot.faults : most_doublings;
  slot.not_before_ns = contact_ns_ + (ns_from_seconds(mission_.cfdp_rest_s) << doublings);
  if (slot.faults++ == 0) report({StatusCode::transfer_damaged, sequence_of(slot), at});
  const bool given_up = slot.faults >= (is_transient(fault) ? most_passing_faults : most_lasting_faults);
  if (!given_up) return;
  report({StatusCode::transfer_given_up, sequence_of(slot), static_cast<std::int64_t>(fault.code)});
  slot.not_before_ns = 0;
  slot.dirty = true;
  TransferRecord record;
  slot.lost = !get(store_, slot.id, record).ok();
  // Without its record the content of a transaction is not known, so nothing is reported.
  if (slot.waiting || slot.lost) return close(slot);
  slot.sender.cancel(0, contact_ns_);
  slot.suspended = false;
}

void FileDelivery::wish(Slot& slot, const TransferRecord& record) {
  if (record.wish == TransferWish::none || slot.gone) return;
  slot.dirty = true;
  switch (record.wish) {
    case TransferWish::suspend:
      slot.suspended = true;
      slot.sender.suspend();
      return;
    case TransferWish::resume:
      slot.suspended = false;
      slot.sender.unsuspend(contact_ns_);
      return;
    case TransferWish::cancel:
      return cancel(slot, record);
    default:
      return;
  }
}

Status FileDelivery::find(Slot& slot, TransferRecord& record, bool& there) {
  const Status found = get(store_, slot.id, record);
  there = found.ok();
  // A newer file of its name has replaced it.
  if (found.is(StatusCode::not_found)) slot.gone = true;
  return found.is(StatusCode::not_found) ? Status{} : found;
}

void FileDelivery::read_wishes() {
  for (Slot& slot : slots_) {
    TransferRecord record;
    bool there = false;
    const Status found = find(slot, record, there);
    // A transfer that was set aside already fails again when its pause is over.
    if (!found.ok() && slot.not_before_ns <= contact_ns_) set_aside(slot, found);
    if (there) wish(slot, record);
  }
}

bool FileDelivery::start(Slot& slot) {
  TransferRecord record;
  bool there = false;
  const Status found = find(slot, record, there);
  if (!found.ok()) set_aside(slot, found);
  if (!there) return false;
  // A number is never used twice. When numbers of the requested length are used up, order_of takes the next longer one.
  state_.sequence = memory_ != nullptr ? memory_->next_transaction(state_.sequence) : state_.sequence + 1;
  state_dirty_ = true;
  record.sequence = state_.sequence;
  slot.sender.begin(order_of(record), settings());
  slot.waiting = false;
  slot.dirty = true;
  slot.stalls = 0;
  slot.saved_progress = 0;
  return true;
}

void FileDelivery::start_waiting() {
  if (!router_.contact()) return;
  const std::size_t most = mission_.cfdp_open_transfers;
  std::size_t open = 0;
  for (const Slot& slot : slots_) {
    // Resting, suspended and set-aside transfers delay no other.
    const bool runs = !slot.waiting && !slot.suspended && slot.sender.phase() != SendPhase::resting;
    open += runs && slot.not_before_ns <= contact_ns_ ? 1U : 0U;
  }
  // Each turn starts a transfer, or sets one aside.
  for (std::size_t turn = 0; turn < slots_.size() && open < most; ++turn) {
    Slot* best = nullptr;
    for (Slot& slot : slots_) {
      if (!slot.waiting || slot.suspended || slot.gone || slot.not_before_ns > contact_ns_) continue;
      if (best == nullptr || slot.priority < best->priority) best = &slot;
    }
    if (best == nullptr) return;
    open += start(*best) ? 1U : 0U;
  }
}

void FileDelivery::close(Slot& slot) {
  slot.dirty = true;
  slot.gone = true;
}

void FileDelivery::look_at(Slot& slot) {
  if (slot.waiting || slot.gone) return;
  slot.sender.tick(contact_ns_);
  const cfdp::SenderCounts& counts = slot.sender.counts();
  if (counts.rests > slot.stalls && slot.sender.phase() == SendPhase::resting) {
    // Reported once per silence.
    if (slot.stalls == 0) report({StatusCode::transfer_stalled, sequence_of(slot), slot.sender.progress()});
    slot.stalls = counts.rests;
  }
  if (counts.rests == 0) slot.stalls = 0;
  if (slot.sender.phase() == SendPhase::closed) {
    close(slot);
    return;
  }
  mark_changes(slot);
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
  record.suspended = slot.suspended ? 1 : 0;
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

void FileDelivery::drop_gone() {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    Slot& slot = slots_[i];
    const bool over = slot.gone && !slot.dirty;
    if (over && !slot.waiting) {
      const cfdp::Sender& sender = slot.sender;
      const cfdp::Header& header = sender.order().header;
      closed_[next_closed_] = {header.sequence, header.destination, sender.condition()};
      next_closed_ = (next_closed_ + 1) % closed_.size();
      SendItem item;
      Pdu pdu;
      if (sender.next(item) && item.kind == PduKind::ack) {
        sender.build(item, pdu);
        static_cast<void>(late_.push_back({pdu.header, pdu.ack}));
      }
      const auto condition = static_cast<std::int64_t>(sender.condition());
      if (sender.outcome() == SendOutcome::delivered) ++counts_.delivered;
      if (sender.outcome() == SendOutcome::cancelled) {
        ++counts_.cancelled;
        report({StatusCode::transfer_cancelled, sequence_of(slot), condition});
      }
      const bool refused = sender.outcome() == SendOutcome::refused;
      const bool spent = sender.outcome() == SendOutcome::spent;
      if (refused || spent) {
        ++counts_.refused;
        const StatusCode code = refused ? StatusCode::transfer_refused : StatusCode::transfer_spent;
        report({code, sequence_of(slot), condition});
        // The file counts as new for a later transaction.
        const std::uint32_t doublings = slot.attempts < most_doublings ? slot.attempts : most_doublings;
        slot.not_before_ns = contact_ns_ + (ns_from_seconds(mission_.cfdp_rest_s) << doublings);
        ++slot.attempts;
        slot.waiting = true;
        slot.gone = false;
      }
    }
    if (!slot.gone || slot.dirty) {
      if (kept != i) slots_[kept] = slot;
      ++kept;
    }
  }
  static_cast<void>(slots_.resize(kept));
}

std::int64_t FileDelivery::sequence_of(const Slot& slot) {
  return static_cast<std::int64_t>(slot.sender.order().header.sequence);
}

void FileDelivery::report(Status event) {
  if (!events_.push_back(event)) ++counts_.events_lost;
}

Status FileDelivery::next_event() {
  if (events_.empty()) return {};
  const Status first = events_[0];
  for (std::size_t i = 0; i + 1 < events_.size(); ++i) events_[i] = events_[i + 1];
  events_.pop_back();
  return first;
}

StepResult FileDelivery::step() {
  if (!router_.present()) return {};
  const TimeNs now = clock_.now();
  const TimeNs passed = now - last_ns_;
  last_ns_ = now;
  if (router_.contact() && passed > 0) contact_ns_ += passed < longest_step_ns ? passed : longest_step_ns;
  take_in();
  Status status = adopt_new();
  if (steps_++ % wish_period_steps == 0) read_wishes();
  start_waiting();
  for (Slot& slot : slots_) look_at(slot);
  uplink_.tick(contact_ns_);
  Status event;
  const Status kept = uplink_.keep(contact_ns_, event);
  if (!event.ok()) report(event);
  if (status.ok()) status = kept;
  const Status saved = save();
  if (status.ok()) status = saved;
  // Before a commit nothing may be confirmed to the ground and no transaction may begin, so nothing unsaved is sent.
  if (state_dirty_) return {status, false};
  drop_gone();
  send();
  return {status.ok() ? next_event() : status, false};
}

}  // namespace ilp
