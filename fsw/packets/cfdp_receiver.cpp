#include "fsw/packets/cfdp_receiver.hpp"

#include <cstring>

#include "fsw/base/crc.hpp"

namespace ilp::cfdp {

void Carried::note(const Pdu& pdu) {
  if (pdu.kind == PduKind::metadata && !named) {
    named = true;
    name_crc = crc32(pdu.metadata.destination_name);
    stated_bytes = pdu.metadata.file_bytes;
  } else if (pdu.kind == PduKind::eof && !ended && pdu.eof.condition == Condition::no_error) {
    ended = true;
    checksum = pdu.eof.checksum;
    file_bytes = pdu.eof.file_bytes;
  }
}

bool Carried::contradicted_by(const Pdu& pdu) const {
  if (pdu.kind == PduKind::metadata && named) {
    return pdu.metadata.file_bytes != stated_bytes || crc32(pdu.metadata.destination_name) != name_crc;
  }
  if (pdu.kind != PduKind::eof || !ended || pdu.eof.condition != Condition::no_error) return false;
  return pdu.eof.checksum != checksum || pdu.eof.file_bytes != file_bytes;
}

void Receiver::begin(const Header& first, const ReceiverSettings& settings, TimeNs now) {
  header_ = first;
  header_.toward_sender = true;
  header_.crc = settings.crc;
  header_.segment_metadata = false;
  header_.record_boundaries = false;
  settings_ = settings;
  phase_ = ReceivePhase::data;
  condition_ = Condition::no_error;
  file_status_ = FileStatus::discarded;
  metadata_ = shown_ = eof_ = false;
  owed_ = {};
  file_bytes_ = end_ = repeats_ = 0;
  carried_ = {};
  deadline_ns_ = received_ns_ = progressed_ns_ = now;
  missing_.clear();
  name_[0] = 0;
  file_.fill(0);
}

void Receiver::resume(const OpenReception& open, const ReceiverSettings& settings, TimeNs now) {
  Header header;
  header.large_file = open.large_file;
  header.id_length = open.id_length;
  header.sequence_length = open.sequence_length;
  header.source = open.source;
  header.sequence = open.sequence;
  header.destination = open.destination;
  begin(header, settings, now);
  shown_ = true;
  if (open.concluded) {
    conclude(open.condition, open.file_status, now);
    return;
  }
  carried_.ended = true;
  carried_.checksum = open.checksum;
  carried_.file_bytes = open.file_bytes;
  receive_eof({Condition::no_error, open.checksum, open.file_bytes, {}}, now);
  owed_.eof_ack = false;
}

OpenReception Receiver::open() const {
  OpenReception open;
  open.concluded = phase_ == ReceivePhase::finished;
  open.used = open.concluded || (eof_ && phase_ != ReceivePhase::closed);
  if (!open.used) return {};
  open.large_file = header_.large_file;
  open.id_length = header_.id_length;
  open.sequence_length = header_.sequence_length;
  open.condition = condition_;
  open.file_status = file_status_;
  open.checksum = checksum_;
  open.file_bytes = file_bytes_;
  open.source = header_.source;
  open.sequence = header_.sequence;
  open.destination = header_.destination;
  return open;
}

void Receiver::abandon() {
  phase_ = ReceivePhase::closed;
  owed_ = {};
}

void Receiver::conclude(Condition condition, FileStatus status, TimeNs now) {
  if (phase_ != ReceivePhase::data && phase_ != ReceivePhase::whole) return;
  phase_ = ReceivePhase::finished;
  condition_ = condition;
  file_status_ = status;
  owed_.nak = false;
  owed_.finished = true;
  repeats_ = 0;
  deadline_ns_ = now + settings_.timer_ns;
}

void Receiver::receive_metadata(const Metadata& metadata, TimeNs now) {
  if (metadata_) return;
  metadata_ = shown_ = true;
  progressed_ns_ = now;
  checksum_type_ = metadata.checksum_type;
  const std::size_t capacity = sizeof(name_) - 1;
  const std::size_t length = metadata.destination_name.size() < capacity ? metadata.destination_name.size() : capacity;
  if (length > 0) std::memcpy(name_, metadata.destination_name.data(), length);
  name_[length] = 0;
  if (metadata.file_bytes > file_.size()) {
    conclude(Condition::filestore_rejection, FileStatus::rejected_by_filestore, now);
  } else if (!is_supported(checksum_type_)) {
    conclude(Condition::unsupported_checksum_type, FileStatus::discarded, now);
  }
}

void Receiver::receive_data(const FileData& data, TimeNs now) {
  if (data.bytes.empty()) return;
  const std::uint64_t most = eof_ ? file_bytes_ : file_.size();
  if (data.offset > most || data.bytes.size() > most - data.offset) {
    conclude(Condition::file_size_error, FileStatus::discarded, now);
    return;
  }
  const auto begin = static_cast<std::uint32_t>(data.offset);
  const auto end = static_cast<std::uint32_t>(data.offset + data.bytes.size());
  // Data that cannot be recorded is treated as lost.
  const bool leaves_gap = begin > end_;
  if (leaves_gap && missing_.full()) return;
  const std::uint32_t missed = octets_in(missing_);
  if (!cut_out(missing_, {begin, end})) return;
  if (end > end_ || octets_in(missing_) < missed) progressed_ns_ = now;
  if (leaves_gap) {
    static_cast<void>(missing_.push_back({end_, begin}));
    owed_.nak = true;
  }
  if (end > end_) end_ = end;
  std::memcpy(&file_[begin], data.bytes.data(), data.bytes.size());
  repeats_ = 0;
  deadline_ns_ = now + settings_.timer_ns;
}

void Receiver::receive_eof(const EndOfFile& eof, TimeNs now) {
  owed_.eof_ack = true;
  eof_condition_ = eof.condition;
  if (phase_ != ReceivePhase::data) return;
  if (eof.condition != Condition::no_error) {
    conclude(eof.condition, FileStatus::discarded, now);
    return;
  }
  if (eof_) return;
  if (eof.file_bytes > file_.size() || eof.file_bytes < end_) {
    const bool too_large = eof.file_bytes > file_.size();
    conclude(too_large ? Condition::filestore_rejection : Condition::file_size_error,
             too_large ? FileStatus::rejected_by_filestore : FileStatus::discarded, now);
    return;
  }
  eof_ = true;
  progressed_ns_ = now;
  checksum_ = eof.checksum;
  file_bytes_ = static_cast<std::uint32_t>(eof.file_bytes);
  // A full list requests a part of the end twice.
  if (end_ < file_bytes_ && !missing_.push_back({end_, file_bytes_})) missing_.back().end = file_bytes_;
  end_ = file_bytes_;
  deadline_ns_ = now + settings_.timer_ns;
  if (!missing_.empty() || !metadata_) owed_.request_all();
}

void Receiver::complete_if_whole(TimeNs now) {
  if (phase_ != ReceivePhase::data || !metadata_ || !eof_ || !missing_.empty()) return;
  FileChecksum checksum(static_cast<ChecksumType>(checksum_type_));
  checksum.add(file());
  owed_.nak = false;
  // The null checksum always agrees.
  if (checksum.value() == checksum_ || checksum_type_ == static_cast<std::uint8_t>(ChecksumType::null)) {
    phase_ = ReceivePhase::whole;
  } else {
    conclude(Condition::file_checksum_failure, FileStatus::discarded, now);
  }
}

void Receiver::receive(const Pdu& pdu, TimeNs now) {
  received_ns_ = now;
  carried_.note(pdu);
  if (pdu.kind == PduKind::eof) {
    receive_eof(pdu.eof, now);
  } else if (pdu.kind == PduKind::ack) {
    if (pdu.ack.of_finished && phase_ == ReceivePhase::finished) phase_ = ReceivePhase::closed;
  } else if (phase_ == ReceivePhase::data) {
    if (pdu.kind == PduKind::metadata) receive_metadata(pdu.metadata, now);
    if (pdu.kind == PduKind::file_data) receive_data(pdu.file_data, now);
    if (pdu.kind == PduKind::prompt) {
      if (pdu.prompt.keep_alive)
        owed_.keep_alive = true;
      else
        owed_.request_all();
    }
    // Without the metadata the purpose of the data is not known.
    if (phase_ == ReceivePhase::data && !metadata_ && end_ > 0 && owed_.nak_from == 0) owed_.request_all();
  }
  complete_if_whole(now);
}

void Receiver::tick(TimeNs now) {
  if (phase_ == ReceivePhase::data && now - received_ns_ >= settings_.inactivity_ns) {
    conclude(Condition::inactivity_detected, FileStatus::discarded, now);
    return;
  }
  const bool waits = phase_ == ReceivePhase::finished || (phase_ == ReceivePhase::data && eof_);
  if (!waits || now < deadline_ns_ || owed_.finished || owed_.nak) return;
  deadline_ns_ = now + settings_.timer_ns;
  if (repeats_++ < settings_.timer_limit) {
    if (phase_ == ReceivePhase::finished)
      owed_.finished = true;
    else
      owed_.request_all();
    return;
  }
  if (phase_ == ReceivePhase::finished)
    phase_ = ReceivePhase::closed;
  else
    conclude(Condition::nak_limit_reached, FileStatus::discarded, now);
}

bool Receiver::next(PduKind& kind) const {
  if (owed_.eof_ack) {
    kind = PduKind::ack;
  } else if (owed_.finished) {
    kind = PduKind::finished;
  } else if (owed_.nak) {
    kind = PduKind::nak;
  } else if (owed_.keep_alive) {
    kind = PduKind::keep_alive;
  } else {
    return false;
  }
  return true;
}

void Receiver::build(PduKind kind, Pdu& pdu) {
  pdu = {};
  pdu.header = header_;
  pdu.kind = kind;
  std::size_t size = 0;
  switch (kind) {
    case PduKind::ack: {
      const bool over = phase_ == ReceivePhase::finished || phase_ == ReceivePhase::closed;
      pdu.ack = {false, eof_condition_, over ? TransactionStatus::terminated : TransactionStatus::active};
      return;
    }
    case PduKind::finished:
      pdu.finished = {condition_, condition_ != Condition::no_error, file_status_, {}};
      if (condition_ == Condition::no_error) return;
      size = write_fault_location(header_.destination, header_.id_length, std::span(options_).first<10>());
      pdu.finished.options = std::span(options_).first(size);
      return;
    case PduKind::keep_alive:
      pdu.keep_alive.progress_bytes = end_;
      return;
    default:
      break;
  }
  nak_through_ = end_;
  if (!metadata_ && owed_.nak_from == 0) size += write_gap(header_, {}, options_.data());
  for (const Segment& segment : missing_) {
    if (segment.begin < owed_.nak_from) continue;
    if (options_.size() - size < 16) {
      nak_through_ = segment.begin;
      break;
    }
    size += write_gap(header_, {segment.begin, segment.end}, options_.data() + size);
  }
  pdu.nak.scope = {0, end_};
  pdu.nak.gaps = std::span(options_).first(size);
}

void Receiver::sent(PduKind kind, TimeNs now) {
  switch (kind) {
    case PduKind::ack:
      owed_.eof_ack = false;
      return;
    case PduKind::finished:
      owed_.finished = false;
      break;
    case PduKind::keep_alive:
      owed_.keep_alive = false;
      return;
    default:
      // The gaps that do not fit into one PDU follow in the next.
      owed_.nak = nak_through_ < end_;
      owed_.nak_from = nak_through_ > 0 ? nak_through_ : 1;
      break;
  }
  deadline_ns_ = now + settings_.timer_ns;
}

}  // namespace ilp::cfdp
