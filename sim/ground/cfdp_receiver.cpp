#include "sim/ground/cfdp_receiver.hpp"

#include <algorithm>

namespace ilp::sim {
namespace {

using cfdp::Condition;
using cfdp::FileStatus;
using cfdp::Pdu;
using cfdp::PduKind;

constexpr std::uint64_t largest_file = std::uint64_t{1} << 30U;

/// Bit by bit, for a reflected polynomial.
std::uint32_t reflected_crc(const std::vector<std::uint8_t>& bytes, std::uint32_t polynomial) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? (crc >> 1U) ^ polynomial : crc >> 1U;
  }
  return ~crc;
}

std::uint32_t sum_of_words(const std::vector<std::uint8_t>& bytes) {
  std::uint32_t sum = 0;
  for (std::size_t at = 0; at < bytes.size(); at += 4) {
    std::uint32_t word = 0;
    for (std::size_t i = 0; i < 4; ++i) word = (word << 8U) | (at + i < bytes.size() ? bytes[at + i] : 0U);
    sum += word;
  }
  return sum;
}

bool checksum_agrees(std::uint8_t type, const std::vector<std::uint8_t>& file, std::uint32_t checksum) {
  switch (type) {
    case 0:
      return sum_of_words(file) == checksum;
    case 2:
      return reflected_crc(file, 0x82F63B78U) == checksum;
    case 3:
      return reflected_crc(file, 0xEDB88320U) == checksum;
    default:
      return type == 15;
  }
}

bool from_a_sender(const Pdu& pdu) {
  switch (pdu.kind) {
    case PduKind::metadata:
    case PduKind::file_data:
    case PduKind::eof:
    case PduKind::prompt:
      return true;
    case PduKind::ack:
      return pdu.ack.of_finished;
    default:
      return false;
  }
}

}  // namespace

CfdpReceiver::CfdpReceiver(CfdpReceiverSettings settings, Send send, Keep keep)
    : settings_(settings), send_(std::move(send)), keep_(std::move(keep)) {}

std::size_t CfdpReceiver::open() const {
  return static_cast<std::size_t>(std::count_if(transactions_.begin(), transactions_.end(),
                                                [](const auto& entry) { return !entry.second.closed; }));
}

void CfdpReceiver::send(const Transaction& t, Pdu pdu) {
  pdu.header = t.header;
  pdu.header.toward_sender = true;
  pdu.header.segment_metadata = false;
  pdu.header.record_boundaries = false;
  Bytes out(4096);
  std::size_t bytes = 0;
  if (!cfdp::encode(pdu, out, bytes).ok()) return;
  out.resize(bytes);
  send_(out);
}

std::vector<cfdp::Gap> CfdpReceiver::gaps(const Transaction& t, std::uint64_t from) const {
  std::vector<cfdp::Gap> list;
  if (!t.metadata) list.push_back({0, 0});
  const std::uint64_t end = t.eof ? t.file_bytes : t.end;
  const auto held = [&](std::uint64_t at) { return at < t.held.size() && t.held[at]; };
  for (std::uint64_t at = from; at < end; ++at) {
    if (held(at)) continue;
    cfdp::Gap gap{at, at};
    while (gap.end < end && !held(gap.end)) ++gap.end;
    list.push_back(gap);
    at = gap.end;
  }
  return list;
}

void CfdpReceiver::send_naks(const Transaction& t, std::uint64_t from) {
  const std::vector<cfdp::Gap> list = gaps(t, from);
  for (std::size_t first = 0; first < list.size(); first += settings_.gaps_in_a_nak) {
    const std::size_t count = std::min(settings_.gaps_in_a_nak, list.size() - first);
    Bytes octets(count * 16);
    std::size_t size = 0;
    for (std::size_t i = 0; i < count; ++i) {
      size += cfdp::write_gap(t.header, list[first + i], octets.data() + size);
    }
    Pdu pdu;
    pdu.kind = PduKind::nak;
    pdu.nak.scope = {0, t.eof ? t.file_bytes : t.end};
    pdu.nak.gaps = std::span<const std::uint8_t>(octets).first(size);
    send(t, pdu);
  }
}

void CfdpReceiver::hear_metadata(Transaction& t, const cfdp::Metadata& metadata) {
  if (t.metadata) return;
  t.metadata = true;
  t.name.assign(metadata.destination_name.begin(), metadata.destination_name.end());
  t.checksum_type = metadata.checksum_type;
}

void CfdpReceiver::hear_data(Transaction& t, const cfdp::FileData& data, double now) {
  counts_.data_bytes += data.bytes.size();
  const std::uint64_t end = data.offset + data.bytes.size();
  if (end > largest_file || (t.eof && end > t.file_bytes)) return;
  if (!t.metadata && settings_.forget_data_before_metadata) {
    t.end = std::max(t.end, end);
    return;
  }
  if (t.file.size() < end) {
    t.file.resize(end);
    t.held.resize(end);
  }
  for (std::size_t i = 0; i < data.bytes.size(); ++i) {
    const auto at = static_cast<std::size_t>(data.offset) + i;
    if (t.held[at]) ++counts_.repeated_bytes;
    t.held[at] = true;
    t.file[at] = data.bytes[i];
  }
  const std::uint64_t before = t.end;
  t.end = std::max(t.end, end);
  if (settings_.immediate_nak && data.offset > before) send_naks(t, before);
  t.next_s = now + settings_.timer_s;
}

void CfdpReceiver::hear_eof(Transaction& t, const cfdp::EndOfFile& eof, double now) {
  Pdu ack;
  ack.kind = PduKind::ack;
  ack.ack = {false, eof.condition, t.closed ? cfdp::TransactionStatus::terminated : cfdp::TransactionStatus::active};
  send(t, ack);
  if (t.closed || t.finished) return;
  if (eof.condition != Condition::no_error) return finish(t, eof.condition, FileStatus::discarded, now);
  if (eof.file_bytes > largest_file) return;
  const bool first = !t.eof;
  t.eof = true;
  t.checksum = eof.checksum;
  t.file_bytes = eof.file_bytes;
  if (t.end > t.file_bytes) return finish(t, Condition::file_size_error, FileStatus::discarded, now);
  if (first) send_naks(t, 0);
  t.next_s = now + settings_.timer_s;
}

void CfdpReceiver::finish(Transaction& t, Condition condition, FileStatus status, double now) {
  t.finished = true;
  t.answer = {condition, status != FileStatus::retained, status, {}};
  t.next_s = now + settings_.timer_s;
  t.repeats = 0;
  Pdu pdu;
  pdu.kind = PduKind::finished;
  pdu.finished = t.answer;
  send(t, pdu);
}

void CfdpReceiver::complete_if_whole(Transaction& t, double now) {
  if (!t.metadata || !t.eof || t.finished || t.closed || !gaps(t, 0).empty()) return;
  t.file.resize(t.file_bytes);
  if (!checksum_agrees(t.checksum_type, t.file, t.checksum)) {
    ++counts_.checksum_failures;
    return finish(t, Condition::file_checksum_failure, FileStatus::discarded, now);
  }
  if (!keep_(t.name, t.file)) return finish(t, Condition::filestore_rejection, FileStatus::rejected_by_filestore, now);
  ++counts_.files;
  finish(t, Condition::no_error, FileStatus::retained, now);
}

void CfdpReceiver::receive(std::span<const std::uint8_t> bytes, double now) {
  ++counts_.pdus;
  Pdu pdu;
  if (!cfdp::decode(bytes, pdu).ok()) {
    ++counts_.malformed;
    return;
  }
  if (pdu.header.destination != settings_.entity || !from_a_sender(pdu)) {
    ++counts_.not_for_us;
    return;
  }
  const Key key{pdu.header.source, pdu.header.sequence};
  if (pdu.kind == PduKind::ack || pdu.kind == PduKind::prompt) {
    const auto found = transactions_.find(key);
    if (found == transactions_.end()) return;
    Transaction& t = found->second;
    if (pdu.kind == PduKind::ack) {
      if (!t.finished) return;
      t.closed = true;
      t.file = {};
      t.held = {};
    } else if (!t.closed && !t.finished) {
      send_naks(t, 0);
    }
    return;
  }
  Transaction& t = transactions_[key];
  t.header = pdu.header;
  t.repeats = 0;
  if (pdu.kind == PduKind::eof) hear_eof(t, pdu.eof, now);
  if (t.closed || t.finished) return;
  if (pdu.kind == PduKind::metadata) hear_metadata(t, pdu.metadata);
  if (pdu.kind == PduKind::file_data) hear_data(t, pdu.file_data, now);
  complete_if_whole(t, now);
}

void CfdpReceiver::tick(double now) {
  for (auto& [key, t] : transactions_) {
    if (t.closed || now < t.next_s || (!t.eof && !t.finished)) continue;
    t.next_s = now + settings_.timer_s;
    const bool over = ++t.repeats > settings_.limit;
    if (t.finished) {
      Pdu pdu;
      pdu.kind = PduKind::finished;
      pdu.finished = t.answer;
      send(t, pdu);
      t.closed = over;
    } else if (over) {
      ++counts_.given_up;
      finish(t, Condition::nak_limit_reached, FileStatus::discarded, now);
    } else {
      send_naks(t, 0);
    }
  }
}

void CfdpReceiver::cancel_all(double now) {
  for (auto& [key, t] : transactions_) {
    if (!t.closed && !t.finished) finish(t, Condition::cancel_request_received, FileStatus::discarded, now);
  }
}

}  // namespace ilp::sim
