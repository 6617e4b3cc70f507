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
    : wiring_{store, router, clock, mission, figures.counts, figures.backlog, memory},
      workspace_(store, clock, mission) {}

cfdp::SenderSettings FileDelivery::settings() const {
  cfdp::SenderSettings settings;
  settings.segment_bytes = wiring_.mission.cfdp_segment_bytes;
  settings.metadata_copies = wiring_.mission.cfdp_metadata_copies;
  settings.timer_ns = ns_from_seconds(wiring_.mission.cfdp_timer_s);
  settings.timer_limit = wiring_.mission.cfdp_timer_limit;
  settings.rest_ns = ns_from_seconds(wiring_.mission.cfdp_rest_s);
  settings.prompt_ns = ns_from_seconds(wiring_.mission.cfdp_prompt_s);
  return settings;
}

cfdp::SendOrder FileDelivery::order_of(const TransferRecord& record) const {
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

Status FileDelivery::restore() {
  workspace_.slots.clear();
  workspace_.late.clear();
  workspace_.closed = {};
  wiring_.backlog = {};
  work_ = {};
  work_.last_ns = wiring_.clock.now();
  const Status loaded = restore_checkpoint(wiring_.store, checkpoint, cursor_, state_);
  if (!restored(loaded)) return loaded;
  workspace_.uplink.restore(state_.uplinks, workspace_.contact_ns);
  return loaded;
}

void FileDelivery::cancel(Slot& slot, const TransferRecord& record) {
  if (slot.waiting) return close(slot);
  cfdp::FileChecksum checksum(record.checksum_type);
  std::uint32_t value = 0;
  bool whole = true;
  for (std::uint32_t at = 0; whole && at < slot.sender.progress();) {
    const std::uint32_t left = slot.sender.progress() - at;
    const std::span<std::uint8_t> piece =
        std::span(workspace_.data).first(left < workspace_.data.size() ? left : workspace_.data.size());
    whole = read_blob<TransferRecord>(wiring_.store, "data", slot.id, at, piece).ok();
    checksum.add(piece);
    at += static_cast<std::uint32_t>(piece.size());
  }
  // The receiver discards the file whatever the checksum is, so an unreadable file has none.
  if (whole) value = checksum.value();
  slot.not_before_ns = 0;
  slot.sender.cancel(value, workspace_.contact_ns);
  slot.suspended = false;
}

void FileDelivery::set_aside(Slot& slot, const Status& fault, std::int64_t at) {
  if (slot.gone) return;
  const std::uint32_t doublings = slot.faults < most_doublings ? slot.faults : most_doublings;
  slot.not_before_ns = workspace_.contact_ns + (ns_from_seconds(wiring_.mission.cfdp_rest_s) << doublings);
  if (slot.faults++ == 0) report({StatusCode::transfer_damaged, sequence_of(slot), at});
  const bool given_up = slot.faults >= (is_transient(fault) ? most_passing_faults : most_lasting_faults);
  if (!given_up) return;
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
      slot.sender.unsuspend(workspace_.contact_ns);
      return;
    case TransferWish::cancel:
      return cancel(slot, record);
    default:
      return;
  }
}

void FileDelivery::read_wishes() {
  for (Slot& slot : workspace_.slots) {
    TransferRecord record;
    bool there = false;
    const Status found = find(slot, record, there);
    // A transfer that was set aside already fails again when its pause is over.
    if (!found.ok() && slot.not_before_ns <= workspace_.contact_ns) set_aside(slot, found);
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
  state_.sequence = wiring_.memory != nullptr ? wiring_.memory->next_transaction(state_.sequence) : state_.sequence + 1;
  work_.state_dirty = true;
  record.sequence = state_.sequence;
  slot.sender.begin(order_of(record), settings());
  slot.waiting = false;
  slot.dirty = true;
  slot.stalls = 0;
  slot.saved_progress = 0;
  return true;
}

void FileDelivery::start_waiting() {
  if (!wiring_.router.contact()) return;
  const std::size_t most = wiring_.mission.cfdp_open_transfers;
  std::size_t open = 0;
  for (const Slot& slot : workspace_.slots) {
    // Resting, suspended and set-aside transfers delay no other.
    const bool runs = !slot.waiting && !slot.suspended && slot.sender.phase() != SendPhase::resting;
    open += runs && slot.not_before_ns <= workspace_.contact_ns ? 1U : 0U;
  }
  // Each turn starts a transfer, or sets one aside.
  for (std::size_t turn = 0; turn < workspace_.slots.size() && open < most; ++turn) {
    Slot* best = nullptr;
    for (Slot& slot : workspace_.slots) {
      if (!slot.waiting || slot.suspended || slot.gone || slot.not_before_ns > workspace_.contact_ns) continue;
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
  slot.sender.tick(workspace_.contact_ns);
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
  for (std::size_t i = 0; i < workspace_.slots.size(); ++i) {
    Slot& slot = workspace_.slots[i];
    const bool over = slot.gone && !slot.dirty;
    if (over && !slot.waiting) {
      const cfdp::Sender& sender = slot.sender;
      const cfdp::Header& header = sender.order().header;
      workspace_.closed[workspace_.next_closed] = {header.sequence, header.destination, sender.condition()};
      workspace_.next_closed = (workspace_.next_closed + 1) % workspace_.closed.size();
      SendItem item;
      Pdu pdu;
      if (sender.next(item) && item.kind == PduKind::ack) {
        sender.build(item, pdu);
        static_cast<void>(workspace_.late.push_back({pdu.header, pdu.ack}));
      }
      const auto condition = static_cast<std::int64_t>(sender.condition());
      if (sender.outcome() == SendOutcome::delivered) ++wiring_.counts.delivered;
      if (sender.outcome() == SendOutcome::cancelled) {
        ++wiring_.counts.cancelled;
        report({StatusCode::transfer_cancelled, sequence_of(slot), condition});
      }
      const bool refused = sender.outcome() == SendOutcome::refused;
      const bool spent = sender.outcome() == SendOutcome::spent;
      if (refused || spent) {
        ++wiring_.counts.refused;
        const StatusCode code = refused ? StatusCode::transfer_refused : StatusCode::transfer_spent;
        report({code, sequence_of(slot), condition});
        // The file counts as new for a later transaction.
        const std::uint32_t doublings = slot.attempts < most_doublings ? slot.attempts : most_doublings;
        slot.not_before_ns = workspace_.contact_ns + (ns_from_seconds(wiring_.mission.cfdp_rest_s) << doublings);
        ++slot.attempts;
        slot.waiting = true;
        slot.gone = false;
      }
    }
    if (!slot.gone || slot.dirty) {
      if (kept != i) workspace_.slots[kept] = slot;
      ++kept;
    }
  }
  static_cast<void>(workspace_.slots.resize(kept));
}

std::int64_t FileDelivery::sequence_of(const Slot& slot) {
  return static_cast<std::int64_t>(slot.sender.order().header.sequence);
}

void FileDelivery::report(Status event) {
  if (!workspace_.events.push_back(event)) ++wiring_.counts.events_lost;
}

Status FileDelivery::next_event() {
  if (workspace_.events.empty()) return {};
  const Status first = workspace_.events[0];
  for (std::size_t i = 0; i + 1 < workspace_.events.size(); ++i) workspace_.events[i] = workspace_.events[i + 1];
  workspace_.events.pop_back();
  return first;
}

void FileDelivery::count_backlog() {
  wiring_.backlog = {work_.adopted_through, 0};
  for (const Slot& slot : workspace_.slots) {
    if (slot.gone || slot.suspended || slot.not_before_ns > workspace_.contact_ns) continue;
    const cfdp::Sender& sender = slot.sender;
    const bool begins = slot.waiting || sender.phase() == SendPhase::data;
    if (begins) wiring_.backlog.bytes += slot.waiting ? slot.bytes : slot.bytes - sender.progress();
    if (slot.waiting || (!begins && sender.phase() != SendPhase::answer)) continue;
    for (const cfdp::Piece& gap : sender.gaps()) wiring_.backlog.bytes += gap.end - gap.begin;
  }
}

StepResult FileDelivery::step() {
  if (!wiring_.router.present()) return {};
  const StepResult result = deliver();
  count_backlog();
  return result;
}

StepResult FileDelivery::deliver() {
  const TimeNs now = wiring_.clock.now();
  const TimeNs passed = now - work_.last_ns;
  work_.last_ns = now;
  if (wiring_.router.contact() && passed > 0)
    workspace_.contact_ns += passed < longest_step_ns ? passed : longest_step_ns;
  take_in();
  Status status = adopt_new();
  if (workspace_.steps++ % wish_period_steps == 0) read_wishes();
  start_waiting();
  for (Slot& slot : workspace_.slots) look_at(slot);
  workspace_.uplink.tick(workspace_.contact_ns);
  Status event;
  const Status kept = workspace_.uplink.keep(workspace_.contact_ns, event);
  if (!event.ok()) report(event);
  if (status.ok()) status = kept;
  const Status saved = save();
  if (status.ok()) status = saved;
  // Before a commit nothing may be confirmed to the ground and no transaction may begin, so nothing unsaved is sent.
  if (work_.state_dirty) return {status, false};
  drop_gone();
  send();
  return {status.ok() ? next_event() : status, false};
}

}  // namespace ilp
