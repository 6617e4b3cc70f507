#include "fsw/downlink/uplink.hpp"

#include <cstring>

#include "cfg/mission_text.hpp"
#include "fsw/base/argument.hpp"
#include "fsw/base/crc.hpp"
#include "fsw/base/text.hpp"
#include "fsw/shared/find.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

using cfdp::Condition;
using cfdp::FileStatus;
using cfdp::Pdu;
using cfdp::PduKind;
using cfdp::ReceivePhase;
using cfdp::Receiver;

/// For a transaction whose metadata or octets are incomplete.
constexpr TimeNs short_patience_ns = ns_per_s;
constexpr TimeNs displaced_report_period_ns = 60 * ns_per_s;

bool is_plain(const char* name) {
  if (name[0] == 0 || name[0] == '.') return false;
  for (const char* c = name; *c != 0; ++c) {
    const bool letter = (*c >= 'a' && *c <= 'z') || (*c >= 'A' && *c <= 'Z');
    const bool other = (*c >= '0' && *c <= '9') || *c == '.' || *c == '-' || *c == '_';
    if (!letter && !other) return false;
  }
  return true;
}

bool is_parameter_file(const char* name) {
  const std::size_t size = std::strlen(name);
  return is_plain(name) && size > 4 && std::strcmp(name + size - 4, ".ini") == 0;
}

bool same_transaction(const cfdp::Header& a, const cfdp::Header& b) {
  return a.source == b.source && a.sequence == b.sequence && a.destination == b.destination;
}

cfdp::ReceiverSettings settings_of(const MissionParameters& mission) {
  cfdp::ReceiverSettings settings;
  settings.crc = mission.cfdp_pdu_crc;
  settings.timer_ns = ns_from_seconds(mission.cfdp_timer_s);
  settings.timer_limit = mission.cfdp_timer_limit;
  settings.inactivity_ns = ns_from_seconds(mission.cfdp_inactivity_s);
  return settings;
}

void conclude(Receiver& receiver, bool retained, TimeNs now) {
  receiver.conclude(retained ? Condition::no_error : Condition::filestore_rejection,
                    retained ? FileStatus::retained : FileStatus::rejected_by_filestore, now);
}

/// The record of the same file of the same transaction, made before a restart.
Result<bool> find_same(Reader<UplinkRecord> store, const Receiver& receiver, std::uint32_t crc, UplinkRecord& record) {
  UplinkRecord same;
  copy_text(same.name, base_name(receiver.name()));
  const auto source = static_cast<std::int64_t>(receiver.header().source);
  const auto sequence = static_cast<std::int64_t>(receiver.header().sequence);
  for (;;) {  // bound: limits::max_uplink_records
    ILP_TAKE(const Found found, find_next(store, record.id, record));
    if (found == Found::nothing) return false;
    if (found == Found::valid && record.source == source && record.sequence == sequence && record.crc32 == crc &&
        std::strcmp(record.name, same.name) == 0)
      return true;
  }
}

Status erase_oldest(StorePart<Erases<UplinkRecord>> store, std::int64_t newest) {
  constexpr auto kept = static_cast<std::int64_t>(limits::max_uplink_records);
  UplinkRecord record;
  for (;;) {  // bound: limits::max_uplink_records and the new one
    ILP_TAKE(const Found found, find_next(store, record.id, record));
    if (found == Found::nothing || record.id + kept > newest) return {};
    // A damaged record does not say whether it is active, and is of no use.
    const bool active = found == Found::valid && record.state == UplinkState::active;
    if (!active) ILP_TRY(erase<UplinkRecord>(store, record.id));
  }
}

}  // namespace

Uplink::Uplink(Tables store, Clock& clock, const MissionParameters& mission, MapFolder* map)
    : store_(store), clock_(clock), mission_(mission), map_(map) {}

void Uplink::restore(const Open& open, TimeNs now) {
  for (std::size_t i = 0; i < receivers_.size(); ++i) {
    receivers_[i].abandon();
    if (open[i].used) receivers_[i].resume(open[i], settings_of(mission_), now);
  }
  closed_ = {};
  next_closed_ = 0;
}

Uplink::Open Uplink::open() const {
  Open open;
  for (std::size_t i = 0; i < receivers_.size(); ++i) open[i] = receivers_[i].open();
  return open;
}

bool Uplink::receive_late(const Pdu& pdu) {
  for (Closed& closed : closed_) {
    if (!closed.used || !same_transaction(closed.header, pdu.header)) continue;
    if (closed.carried.contradicted_by(pdu)) {
      closed = {};
      return false;
    }
    if (pdu.kind == PduKind::eof) {
      closed.owes_ack = true;
      closed.owes_finished = true;
      closed.eof_condition = pdu.eof.condition;
    } else if (pdu.kind == PduKind::ack) {
      closed.owes_finished = false;
    }
    return true;
  }
  return false;
}

Receiver* Uplink::receiver_for(TimeNs now) {
  // A lost request for gaps is repeated after one timer.
  const TimeNs patience_ns = ns_from_seconds(2 * mission_.cfdp_timer_s);
  Receiver* best = nullptr;
  for (Receiver& receiver : receivers_) {
    if (receiver.phase() == ReceivePhase::closed) return &receiver;
    // A complete file is stored in this step.
    if (receiver.phase() == ReceivePhase::whole) continue;
    const TimeNs idle_ns = now - receiver.progressed_ns();
    const bool begun = receiver.shown() && receiver.octets() > 0;
    if (idle_ns < (begun ? patience_ns : short_patience_ns)) continue;
    const bool rather = best == nullptr || (best->shown() && !receiver.shown()) ||
                        (best->shown() == receiver.shown() && receiver.progressed_ns() < best->progressed_ns());
    if (rather) best = &receiver;
  }
  if (best != nullptr) displace(*best, now);
  return best;
}

void Uplink::displace(Receiver& receiver, TimeNs now) {
  const bool concluded = receiver.phase() == ReceivePhase::finished;
  if (concluded) remember(receiver);
  // Forged transactions are many, so they are reported at most once a minute.
  if (!concluded && receiver.shown() && now >= silent_until_ns_) {
    silent_until_ns_ = now + displaced_report_period_ns;
    abandoned_ = {StatusCode::uplink_displaced, static_cast<std::int64_t>(receiver.header().source),
                  static_cast<std::int64_t>(receiver.octets())};
  }
  receiver.abandon();
}

bool Uplink::receive(const Pdu& pdu, TimeNs now) {
  for (Receiver& receiver : receivers_) {
    if (receiver.phase() == ReceivePhase::closed || !same_transaction(receiver.header(), pdu.header)) continue;
    // The number of an open transaction with another file: its sender has started over.
    if (receiver.carried().contradicted_by(pdu)) receiver.begin(pdu.header, settings_of(mission_), now);
    receiver.receive(pdu, now);
    if (receiver.phase() == ReceivePhase::closed) remember(receiver);
    return true;
  }
  if (receive_late(pdu)) return true;
  if (pdu.header.unacknowledged || pdu.kind == PduKind::ack || pdu.kind == PduKind::prompt) return false;
  if (pdu.header.source != mission_.cfdp_ground_entity) return false;
  Receiver* receiver = receiver_for(now);
  if (receiver == nullptr) return false;
  receiver->begin(pdu.header, settings_of(mission_), now);
  receiver->receive(pdu, now);
  return true;
}

void Uplink::remember(const Receiver& receiver) {
  Closed& closed = closed_[next_closed_];
  next_closed_ = (next_closed_ + 1) % closed_.size();
  closed = {};
  closed.header = receiver.header();
  closed.used = true;
  closed.condition = receiver.condition();
  closed.file_status = receiver.file_status();
  closed.carried = receiver.carried();
  const bool by_limit = closed.condition == Condition::nak_limit_reached ||
                        closed.condition == Condition::inactivity_detected ||
                        closed.condition == Condition::file_checksum_failure;
  if (!by_limit) return;
  abandoned_ = {StatusCode::uplink_given_up, static_cast<std::int64_t>(closed.header.source),
                static_cast<std::int64_t>(closed.condition)};
}

void Uplink::tick(TimeNs now) {
  for (Receiver& receiver : receivers_) {
    if (receiver.phase() == ReceivePhase::closed) continue;
    receiver.tick(now);
    if (receiver.phase() == ReceivePhase::closed) remember(receiver);
  }
}

Status Uplink::check(const Receiver& receiver, UplinkRecord& record) {
  const std::span<const std::uint8_t> file = receiver.file();
  copy_text(record.name, base_name(receiver.name()));
  record.source = static_cast<std::int64_t>(receiver.header().source);
  record.sequence = static_cast<std::int64_t>(receiver.header().sequence);
  record.crc32 = crc32(file);
  record.received_ns = clock_.now();
  Status verdict = StatusCode::unsupported_format;
  if (is_parameter_file(record.name)) {
    MissionParameters trial = mission_;
    MissionText text(mission_);
    text.add(file);
    verdict = text.finish(trial);
  }
  record.state = verdict.ok() ? UplinkState::checked : UplinkState::rejected;
  record.fault = static_cast<std::uint16_t>(verdict.code);
  record.fault_place = verdict.is(StatusCode::parameter_out_of_range) ? verdict.b : verdict.a;
  // A rejected file is of no use.
  record.data.bytes = verdict.ok() ? static_cast<std::uint32_t>(file.size()) : 0;
  return {};
}

Status Uplink::store_file(const Receiver& receiver, UplinkRecord& record) {
  Transaction transaction(store_);
  ILP_TRY(transaction.begin());
  std::int64_t newest = 0;
  ILP_TRY(newest_id<UplinkRecord>(store_, newest));
  record.id = newest + 1;
  ILP_TRY(put(store_, record));
  if (record.data.bytes != 0) ILP_TRY(write_blob<UplinkRecord>(store_, "data", record.id, 0, receiver.file()));
  ILP_TRY(erase_oldest(store_, record.id));
  return transaction.commit();
}

Status Uplink::keep_parameters(Receiver& receiver, TimeNs now, Status& event) {
  UplinkRecord record;
  const std::uint32_t crc = crc32(receiver.file());
  ILP_TAKE(const bool known, find_same(store_, receiver, crc, record));
  if (!known) {
    record = {};
    ILP_TRY(check(receiver, record));
    ILP_TRY(store_file(receiver, record));
    const auto bytes = static_cast<std::int64_t>(receiver.file().size());
    event = record.state == UplinkState::rejected ? Status{StatusCode::uplink_rejected, record.id, record.fault_place}
                                                  : Status{StatusCode::uplink_received, record.id, bytes};
  }
  conclude(receiver, record.state != UplinkState::rejected, now);
  return {};
}

void Uplink::keep_part_of_map(Receiver& receiver, TimeNs now, Status& event) {
  Status updates;
  const Status kept =
      keep_map_file(base_name(receiver.name()), receiver.file(), map_, mission_, map_workspace_, updates);
  if (!updates.ok()) event = updates;
  if (!kept.ok()) event = {StatusCode::map_file_refused, static_cast<std::int64_t>(kept.code), kept.a};
  conclude(receiver, kept.ok(), now);
}

Status Uplink::keep(TimeNs now, Status& event) {
  event = abandoned_;
  abandoned_ = {};
  for (Receiver& receiver : receivers_) {
    if (receiver.phase() != ReceivePhase::whole) continue;
    if (!is_map_file(base_name(receiver.name()))) return keep_parameters(receiver, now, event);
    keep_part_of_map(receiver, now, event);
    return {};
  }
  return {};
}

bool Uplink::next(Pdu& pdu) {
  for (going_ = 0; going_ < receivers_.size(); ++going_) {
    if (!receivers_[going_].next(going_kind_)) continue;
    receivers_[going_].build(going_kind_, pdu);
    return true;
  }
  for (const Closed& closed : closed_) {
    if (closed.owes_ack || closed.owes_finished) {
      pdu = {};
      pdu.header = closed.header;
      going_kind_ = pdu.kind = closed.owes_ack ? PduKind::ack : PduKind::finished;
      pdu.ack = {false, closed.eof_condition, cfdp::TransactionStatus::terminated};
      pdu.finished = {closed.condition, closed.condition != Condition::no_error, closed.file_status, {}};
      return true;
    }
    ++going_;
  }
  return false;
}

void Uplink::sent(TimeNs now) {
  if (going_ < receivers_.size()) return receivers_[going_].sent(going_kind_, now);
  Closed& closed = closed_[going_ - receivers_.size()];
  (going_kind_ == PduKind::ack ? closed.owes_ack : closed.owes_finished) = false;
}

Status activate_uplink(StorePart<Changes<UplinkRecord>> store, std::int64_t id, TimeNs now,
                       MissionParameters& mission) {
  UplinkRecord record;
  ILP_TRY(get(store, id, record));
  if (record.state == UplinkState::rejected) return out_of_range(Argument::uplinked_file, id);
  MissionText text(mission);
  for (std::size_t at = 0; at < record.data.bytes;) {
    std::uint8_t segment[256];
    const std::size_t size = record.data.bytes - at < sizeof(segment) ? record.data.bytes - at : sizeof(segment);
    ILP_TRY(read_blob<UplinkRecord>(store, "data", id, at, {segment, size}));
    text.add({segment, size});
    at += size;
  }
  MissionParameters changed = mission;
  ILP_TRY(text.finish(changed));
  UplinkRecord other;
  for (;;) {  // bound: limits::max_uplink_records
    ILP_TAKE(const Found found, find_next(store, other.id, other));
    if (found == Found::nothing) break;
    if (found == Found::damaged || other.state != UplinkState::active) continue;
    other.state = UplinkState::superseded;
    ILP_TRY(amend(store, other));
  }
  record.state = UplinkState::active;
  record.activated_ns = now;
  ILP_TRY(amend(store, record));
  mission = changed;
  return {};
}

}  // namespace ilp
