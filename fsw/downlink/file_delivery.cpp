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
/// Longer gaps between two steps are a freeze, in which nothing could be received.
constexpr TimeNs longest_step_ns = ns_per_s;
constexpr std::uint32_t most_doublings = 6;
/// Faults of the store for one transfer until it is abandoned: faults that may pass, and permanent ones.
constexpr std::uint32_t most_passing_faults = 10;
constexpr std::uint32_t most_lasting_faults = 3;

}  // namespace

constexpr CheckpointForm FileDelivery::checkpoint = checkpoint_form<State>(component_id);

FileDelivery::FileDelivery(Tables store, PacketRouter& router, Clock& clock, const MissionParameters& mission,
                           DeliveryFigures& figures, FlightMemory* memory)
    : store_(store),
      router_(router),
      clock_(clock),
      mission_(mission),
      counts_(figures.counts),
      backlog_(figures.backlog),
      memory_(memory),
      uplink_(store, clock, mission) {}

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
  backlog_ = {};
  last_ns_ = clock_.now();
  state_dirty_ = false;
  const Status loaded = restore_checkpoint(store_, checkpoint, cursor_, state_);
  if (!restored(loaded)) return loaded;
  uplink_.restore(state_.uplinks, contact_ns_);
  return loaded;
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

void FileDelivery::count_backlog() {
  backlog_ = {adopted_through_, 0};
  for (const Slot& slot : slots_) {
    if (slot.gone || slot.suspended || slot.not_before_ns > contact_ns_) continue;
    const cfdp::Sender& sender = slot.sender;
    const bool begins = slot.waiting || sender.phase() == SendPhase::data;
    if (begins) backlog_.bytes += slot.waiting ? slot.bytes : slot.bytes - sender.progress();
    if (slot.waiting || (!begins && sender.phase() != SendPhase::answer)) continue;
    for (const cfdp::Piece& gap : sender.gaps()) backlog_.bytes += gap.end - gap.begin;
  }
}

StepResult FileDelivery::step() {
  if (!router_.present()) return {};
  const StepResult result = deliver();
  count_backlog();
  return result;
}

StepResult FileDelivery::deliver() {
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
