#include "fsw/downlink/file_delivery.hpp"

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

}  // namespace

constexpr CheckpointForm FileDelivery::checkpoint = checkpoint_form<State>(component_id);

FileDelivery::FileDelivery(Tables store, PacketRouter& router, Clock& clock, const MissionParameters& mission,
                           DeliveryFigures& figures, FlightMemory* memory, MapFolder* map)
    : wiring_{store, router, clock, mission, figures.counts, figures.backlog, memory},
      workspace_(store, clock, mission, map) {}

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
      return records().cancel(slot, record);
    default:
      return;
  }
}

void FileDelivery::read_wishes() {
  for (Slot& slot : workspace_.slots) {
    TransferRecord record;
    const Result<bool> found = records().find(slot, record);
    // A transfer that was quarantined already fails again when its pause is over.
    if (!found.ok() && slot.not_before_ns <= workspace_.contact_ns) records().quarantine(slot, found.status());
    if (found.value()) wish(slot, record);
  }
}

bool FileDelivery::start(Slot& slot) {
  TransferRecord record;
  const Result<bool> found = records().find(slot, record);
  if (!found.ok()) records().quarantine(slot, found.status());
  if (!found.value()) return false;
  // A number is never used twice. When numbers of the requested length are used up, order_of takes the next longer one.
  state_.sequence = wiring_.memory != nullptr ? wiring_.memory->next_transaction(state_.sequence) : state_.sequence + 1;
  work_.state_dirty = true;
  record.sequence = state_.sequence;
  slot.sender.begin(records().order_of(record), records().settings());
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

void FileDelivery::check(Slot& slot) {
  if (slot.waiting || slot.gone) return;
  slot.sender.tick(workspace_.contact_ns);
  const cfdp::SenderCounts& counts = slot.sender.counts();
  if (counts.rests > slot.stalls && slot.sender.phase() == SendPhase::resting) {
    // Reported once per silence.
    if (slot.stalls == 0)
      records().report({StatusCode::transfer_stalled, FileDeliveryPart::sequence_of(slot), slot.sender.progress()});
    slot.stalls = counts.rests;
  }
  if (counts.rests == 0) slot.stalls = 0;
  if (slot.sender.phase() == SendPhase::closed) {
    records().close(slot);
    return;
  }
  records().mark_changes(slot);
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
        records().report({StatusCode::transfer_cancelled, FileDeliveryPart::sequence_of(slot), condition});
      }
      const bool refused = sender.outcome() == SendOutcome::refused;
      const bool spent = sender.outcome() == SendOutcome::spent;
      if (refused || spent) {
        ++wiring_.counts.refused;
        const StatusCode code = refused ? StatusCode::transfer_refused : StatusCode::transfer_spent;
        records().report({code, FileDeliveryPart::sequence_of(slot), condition});
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

Status FileDelivery::next_event() {
  if (workspace_.events.empty()) return {};
  const Status first = workspace_.events[0];
  workspace_.events.erase(0);
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
    for (const cfdp::Segment& gap : sender.gaps()) wiring_.backlog.bytes += gap.end - gap.begin;
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
  link().take_in();
  Status status = records().adopt_new();
  if (workspace_.steps++ % wish_period_steps == 0) read_wishes();
  start_waiting();
  for (Slot& slot : workspace_.slots) check(slot);
  workspace_.uplink.tick(workspace_.contact_ns);
  Status event;
  const Status kept = workspace_.uplink.keep(workspace_.contact_ns, event);
  if (!event.ok()) records().report(event);
  if (status.ok()) status = kept;
  const Status saved = records().save();
  if (status.ok()) status = saved;
  // Before a commit nothing may be confirmed to the ground and no transaction may begin, so nothing unsaved is sent.
  if (work_.state_dirty) return {status, false};
  drop_gone();
  link().send();
  return {status.ok() ? next_event() : status, false};
}

}  // namespace ilp
