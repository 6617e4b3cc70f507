#include "fsw/packets/cfdp_sender.hpp"

#include <cstring>

namespace ilp::cfdp {

void Sender::begin(const SendOrder& order, const SenderSettings& settings) {
  *this = Sender{};
  order_ = order;
  settings_ = settings;
  phase_ = SendPhase::data;
  owed_metadata_ = settings.metadata_copies > 0 ? settings.metadata_copies : 1;
}

void Sender::resume(const SendOrder& order, const SenderSettings& settings, std::uint32_t progress, bool all_sent,
                    std::span<const Segment> gaps) {
  begin(order, settings);
  progress_ = progress < order.file_bytes ? progress : order.file_bytes;
  std::array<Segment, limits::max_file_gaps> within{};
  std::size_t count = 0;
  for (const Segment& gap : gaps) {
    if (count == within.size()) break;
    within[count++] = {gap.begin, gap.end < progress_ ? gap.end : progress_};
  }
  counts_.dropped_gaps += merge_missing(gaps_, std::span(within).first(count)).dropped;
  if (!all_sent) return;
  progress_ = order.file_bytes;
  phase_ = SendPhase::answer;
  // The receiver has the metadata, or requests it.
  owed_metadata_ = 0;
  owes_eof_ = true;
}

Segment Sender::segment_of(Segment segment) const {
  if (segment.end - segment.begin > settings_.segment_bytes) segment.end = segment.begin + settings_.segment_bytes;
  return segment;
}

bool Sender::next(SendItem& item) const {
  item = {};
  if (owes_finished_ack_) {
    item.kind = PduKind::ack;
    return true;
  }
  if (suspended_ || phase_ == SendPhase::closed || phase_ == SendPhase::resting) return false;
  if (phase_ != SendPhase::cancelling) {
    if (owed_metadata_ > 0) return true;
    item.kind = PduKind::file_data;
    if (!gaps_.empty()) {
      item.again = true;
      item.segment = segment_of(gaps_[0]);
      return true;
    }
    if (progress_ < order_.file_bytes) {
      item.segment = segment_of({progress_, order_.file_bytes});
      return true;
    }
  }
  item.kind = PduKind::eof;
  if (owes_eof_ || phase_ == SendPhase::data) return true;
  item.kind = PduKind::prompt;
  return owes_prompt_;
}

void Sender::build(const SendItem& item, Pdu& pdu) const {
  pdu = {};
  pdu.header = order_.header;
  pdu.header.toward_sender = false;
  pdu.kind = item.kind;
  const bool cancelling = phase_ == SendPhase::cancelling;
  const auto* name = reinterpret_cast<const std::uint8_t*>(order_.name);
  switch (item.kind) {
    case PduKind::metadata:
      pdu.metadata.checksum_type = order_.checksum_type;
      pdu.metadata.file_bytes = order_.file_bytes;
      pdu.metadata.source_name = {name, strnlen(order_.name, sizeof(order_.name))};
      pdu.metadata.destination_name = pdu.metadata.source_name;
      break;
    case PduKind::file_data:
      pdu.file_data.offset = item.segment.begin;
      break;
    case PduKind::eof:
      pdu.eof.condition = cancelling ? Condition::cancel_request_received : Condition::no_error;
      pdu.eof.checksum = cancelling ? cancel_checksum_ : order_.checksum;
      pdu.eof.file_bytes = cancelling ? progress_ : order_.file_bytes;
      if (cancelling) pdu.eof.options = {fault_location_, fault_location_bytes_};
      break;
    case PduKind::ack:
      pdu.ack = {true, condition_, TransactionStatus::active};
      break;
    default:
      pdu.prompt.keep_alive = false;
      break;
  }
}

void Sender::sent(const SendItem& item, TimeNs now) {
  deadline_ns_ = now + settings_.timer_ns;
  switch (item.kind) {
    case PduKind::ack:
      owes_finished_ack_ = false;
      break;
    case PduKind::metadata:
      if (owed_metadata_ > 0) --owed_metadata_;
      break;
    case PduKind::file_data:
      if (!item.again) {
        progress_ = item.segment.end;
        break;
      }
      counts_.resent_bytes += item.segment.end - item.segment.begin;
      gaps_[0].begin = item.segment.end;
      if (gaps_[0].begin < gaps_[0].end) break;
      gaps_.erase(0);
      break;
    case PduKind::eof:
      owes_eof_ = false;
      ++repeats_;
      if (phase_ == SendPhase::data) {
        phase_ = SendPhase::answer;
        repeats_ = 0;
        received_ns_ = now;
      }
      break;
    default:
      owes_prompt_ = false;
      ++repeats_;
      break;
  }
}

void Sender::receive_nak(const Pdu& pdu, TimeNs now) {
  shown_ = true;
  // A receiver that requests data has not finished.
  held_finished_ = false;
  // A request shows that the receiver is there: the EOF is not repeated before its time.
  if (phase_ == SendPhase::resting) phase_ = SendPhase::answer;
  if (phase_ != SendPhase::data && phase_ != SendPhase::answer) return;
  deadline_ns_ = now + settings_.timer_ns;
  std::array<Segment, limits::max_file_gaps> asked{};
  std::size_t taken = 0;
  const std::size_t count = gap_count(pdu.header, pdu.nak);
  for (std::size_t i = 0; i < count; ++i) {
    const Gap gap = gap_at(pdu.header, pdu.nak, i);
    if (gap.begin == 0 && gap.end == 0) {
      if (owed_metadata_ == 0) owed_metadata_ = 1;
      continue;
    }
    if (gap.begin >= gap.end || gap.end > order_.file_bytes) ++counts_.bad_gaps;
    // Data that was never sent follows in any case.
    const std::uint64_t end = gap.end < progress_ ? gap.end : progress_;
    if (gap.begin >= end) continue;
    if (taken == asked.size()) {
      ++counts_.dropped_gaps;
      continue;
    }
    asked[taken++] = {static_cast<std::uint32_t>(gap.begin), static_cast<std::uint32_t>(end)};
  }
  const MergeCounts merged = merge_missing(gaps_, std::span(asked).first(taken));
  counts_.dropped_gaps += merged.dropped;
  counts_.gap_steps += merged.steps + static_cast<std::uint32_t>(count);
}

void Sender::deliver() {
  owes_finished_ack_ = true;
  outcome_ = SendOutcome::delivered;
  phase_ = SendPhase::closed;
}

void Sender::receive_finished(const Finished& finished) {
  if (outcome_ != SendOutcome::open) {
    owes_finished_ack_ = true;
    return;
  }
  condition_ = finished.condition;
  const bool retained =
      finished.condition == Condition::no_error && !finished.incomplete && finished.file_status == FileStatus::retained;
  // Before the EOF the receiver cannot know that the file is complete.
  const bool all_sent = phase_ != SendPhase::data && progress_ == order_.file_bytes;
  if (retained && all_sent) {
    if (shown_ || phase_ == SendPhase::cancelling) return deliver();
    held_finished_ = true;
    owes_eof_ = true;
    eof_acknowledged_ = false;
    phase_ = SendPhase::answer;
    return;
  }
  owes_finished_ack_ = true;
  const bool cancelled = finished.condition == Condition::cancel_request_received || phase_ == SendPhase::cancelling;
  outcome_ = cancelled ? SendOutcome::cancelled : SendOutcome::refused;
  phase_ = SendPhase::closed;
}

void Sender::receive_ack(const Ack& ack, TimeNs now) {
  if (ack.of_finished) return;
  if (phase_ == SendPhase::cancelling) {
    outcome_ = SendOutcome::cancelled;
    phase_ = SendPhase::closed;
  }
  if (phase_ == SendPhase::resting) phase_ = SendPhase::answer;
  if (phase_ != SendPhase::answer) return;
  eof_acknowledged_ = true;
  owes_eof_ = false;
  deadline_ns_ = now + settings_.timer_ns;
  if (ack.status == TransactionStatus::active) {
    shown_ = true;
    if (held_finished_) deliver();
    return;
  }
  // A receiver that has worked on this file may have closed it: its Finished follows the ACK.
  constexpr std::uint32_t most_over_answers = 2;
  if (shown_ && ++over_answers_ < most_over_answers) return;
  outcome_ = SendOutcome::spent;
  phase_ = SendPhase::closed;
}

void Sender::receive(const Pdu& pdu, TimeNs now) {
  repeats_ = 0;
  counts_.rests = 0;
  received_ns_ = now;
  switch (pdu.kind) {
    case PduKind::finished:
      receive_finished(pdu.finished);
      break;
    case PduKind::nak:
      receive_nak(pdu, now);
      break;
    case PduKind::keep_alive:
      shown_ = true;
      break;
    case PduKind::ack:
      receive_ack(pdu.ack, now);
      break;
    default:
      break;
  }
}

void Sender::expire(TimeNs now) {
  if (phase_ == SendPhase::resting) {
    phase_ = SendPhase::answer;
    // A receiver that has lost the transaction begins it again.
    owed_metadata_ = 1;
    owes_eof_ = true;
    eof_acknowledged_ = false;
    repeats_ = 0;
    return;
  }
  if (repeats_ >= settings_.timer_limit) {
    if (phase_ == SendPhase::cancelling) {
      outcome_ = SendOutcome::cancelled;
      phase_ = SendPhase::closed;
      return;
    }
    phase_ = SendPhase::resting;
    ++counts_.rests;
    deadline_ns_ = now + settings_.rest_ns;
    return;
  }
  if (!eof_acknowledged_) {
    owes_eof_ = true;
    return;
  }
  // After the ACK the receiver continues, and its timers repeat its PDUs.
  deadline_ns_ = now + settings_.timer_ns;
  if (settings_.prompt_ns > 0 && now - received_ns_ >= settings_.prompt_ns) {
    owes_prompt_ = true;
  } else {
    ++repeats_;
  }
}

void Sender::tick(TimeNs now) {
  if (suspended_ || phase_ == SendPhase::closed || phase_ == SendPhase::data) return;
  SendItem waiting;
  // Data that was not sent cannot be answered.
  if (phase_ != SendPhase::resting && next(waiting)) return;
  if (now >= deadline_ns_) expire(now);
}

void Sender::unsuspend(TimeNs now) {
  suspended_ = false;
  deadline_ns_ = now + settings_.timer_ns;
}

void Sender::cancel(std::uint32_t checksum, TimeNs now) {
  if (phase_ == SendPhase::closed || phase_ == SendPhase::cancelling) return;
  const Header& header = order_.header;
  cancel_checksum_ = checksum;
  fault_location_bytes_ = static_cast<std::uint8_t>(
      write_fault_location(header.source, header.id_length, std::span<std::uint8_t, 10>(fault_location_)));
  phase_ = SendPhase::cancelling;
  suspended_ = false;
  owes_eof_ = true;
  eof_acknowledged_ = false;
  repeats_ = 0;
  deadline_ns_ = now + settings_.timer_ns;
}

}  // namespace ilp::cfdp
