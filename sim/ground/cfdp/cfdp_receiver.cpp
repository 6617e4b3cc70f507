#include "sim/ground/cfdp/cfdp_receiver.hpp"

#include <algorithm>
#include <iterator>

#include "fsw/base/crc.hpp"

namespace ilp::ground_cfdp {
using cfdp::Condition;
using cfdp::FileStatus;
using cfdp::Pdu;
using cfdp::PduKind;
namespace {

/// Memory of a piece besides its octets: a node in each of the two maps, two blocks of the heap.
constexpr std::uint64_t segment_overhead_bytes = 192;

std::uint32_t sum_of_words(const std::vector<std::uint8_t>& bytes) {
  std::uint32_t sum = 0;
  for (std::size_t at = 0; at < bytes.size(); at += 4) {
    std::uint32_t word = 0;
    for (std::size_t i = 0; i < 4; ++i) word = (word << 8U) | (at + i < bytes.size() ? bytes[at + i] : 0U);
    sum += word;
  }
  return sum;
}

constexpr std::uint8_t modular = 0, castagnoli = 2, ethernet = 3, null = 15;

bool is_checksum_type(std::uint8_t type) {
  return type == modular || type == castagnoli || type == ethernet || type == null;
}

bool checksum_agrees(std::uint8_t type, const std::vector<std::uint8_t>& file, std::uint32_t checksum) {
  switch (type) {
    case modular:
      return sum_of_words(file) == checksum;
    case castagnoli:
      return crc32c(file) == checksum;
    case ethernet:
      return crc32(file) == checksum;
    default:
      return type == null;
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

std::uint64_t ReceivedSegments::add(std::uint64_t offset, std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return 0;
  std::uint64_t begin = offset, end = offset + bytes.size(), at = offset, added = 0;
  auto run = runs_.upper_bound(offset);
  if (run != runs_.begin() && std::prev(run)->second >= offset) --run;
  // All runs that the segment touches become one with it.
  while (at < end || (run != runs_.end() && run->first <= end)) {
    const std::uint64_t next = run != runs_.end() ? std::min(run->first, end) : end;
    if (at < next) {
      const auto part = bytes.subspan(at - offset, next - at);
      segments_.emplace(at, Bytes(part.begin(), part.end()));
      added += part.size();
      at = next;
    }
    if (run == runs_.end() || run->first > end) break;
    begin = std::min(begin, run->first);
    at = std::max(at, run->second);
    run = runs_.erase(run);
  }
  runs_[begin] = std::max(at, end);
  held_bytes_ += added;
  return added;
}

bool ReceivedSegments::whole(std::uint64_t end) const {
  return end == 0 || (!runs_.empty() && runs_.begin()->first == 0 && runs_.begin()->second >= end);
}

std::vector<cfdp::Gap> ReceivedSegments::gaps(std::uint64_t begin, std::uint64_t end, std::size_t most) const {
  std::vector<cfdp::Gap> list;
  auto run = runs_.upper_bound(begin);
  if (run != runs_.begin() && std::prev(run)->second > begin) begin = std::prev(run)->second;
  while (begin < end && list.size() < most) {
    const std::uint64_t stop = run == runs_.end() ? end : std::min(end, run->first);
    if (begin < stop) list.push_back({begin, stop});
    if (run == runs_.end()) break;
    begin = run->second;
    ++run;
  }
  return list;
}

ReceivedSegments::Bytes ReceivedSegments::file(std::uint64_t end) const {
  Bytes file;
  file.reserve(end);
  for (const auto& [begin, bytes] : segments_) {
    if (begin >= end) break;
    file.insert(file.end(), bytes.begin(), bytes.end());
  }
  file.resize(end);
  return file;
}

std::uint64_t ReceivedSegments::memory_bytes() const {
  return held_bytes_ + segment_overhead_bytes * segments_.size();
}

CfdpReceiver::CfdpReceiver(CfdpReceiverSettings settings, Send send, Keep keep)
    : settings_(settings), send_(std::move(send)), keep_(std::move(keep)) {}

CfdpReceiver::FileMetadata CfdpReceiver::metadata_of(const cfdp::Metadata& metadata) {
  return {{metadata.destination_name.begin(), metadata.destination_name.end()},
          metadata.checksum_type,
          metadata.file_bytes};
}

void CfdpReceiver::send(const cfdp::Header& header, Pdu pdu) {
  pdu.header = header;
  pdu.header.toward_sender = true;
  pdu.header.segment_metadata = false;
  pdu.header.record_boundaries = false;
  Bytes out(4096);
  std::size_t bytes = 0;
  if (!cfdp::encode(pdu, out, bytes).ok()) return;
  out.resize(bytes);
  send_(out);
}

void CfdpReceiver::send_finished(const cfdp::Header& header, const cfdp::Finished& answer) {
  Pdu pdu;
  pdu.kind = PduKind::finished;
  pdu.finished = answer;
  send(header, pdu);
}

void CfdpReceiver::acknowledge_eof(const cfdp::Header& header, const cfdp::EndOfFile& eof,
                                   cfdp::TransactionStatus status) {
  Pdu pdu;
  pdu.kind = PduKind::ack;
  pdu.ack = {false, eof.condition, status};
  send(header, pdu);
}

void CfdpReceiver::send_naks(const Transaction& t, std::uint64_t from) {
  const std::uint64_t end = t.eof ? t.eof->file_bytes : t.end;
  std::vector<cfdp::Gap> list = t.segments.gaps(from, end, settings_.gaps_at_once);
  if (!t.metadata) list.insert(list.begin(), cfdp::Gap{0, 0});
  for (std::size_t first = 0; first < list.size(); first += settings_.gaps_in_a_nak) {
    const std::size_t count = std::min(settings_.gaps_in_a_nak, list.size() - first);
    Bytes octets(count * 16);
    std::size_t size = 0;
    for (std::size_t i = 0; i < count; ++i) {
      size += cfdp::write_gap(t.header, list[first + i], octets.data() + size);
    }
    Pdu pdu;
    pdu.kind = PduKind::nak;
    pdu.nak.scope = {0, end};
    pdu.nak.gaps = std::span<const std::uint8_t>(octets).first(size);
    send(t.header, pdu);
  }
}

void CfdpReceiver::drop_data(Transaction& t) {
  held_bytes_ -= t.segments.memory_bytes();
  t.segments = {};
}

void CfdpReceiver::close(const Key& key) {
  const auto found = transactions_.find(key);
  Transaction& t = found->second;
  drop_data(t);
  closed_[key] = {std::move(t.metadata), t.eof, t.answer};
  closed_order_.push_back(key);
  transactions_.erase(found);
  if (closed_.size() <= settings_.max_closed) return;
  closed_.erase(closed_order_.front());
  closed_order_.pop_front();
}

/// Drops transactions other than `but` until at most `most_open` are open and `more_bytes` more fit, or none is left
/// to drop.
void CfdpReceiver::make_room(const Key& but, std::size_t most_open, std::uint64_t more_bytes) {
  while (true) {
    const bool too_many = transactions_.size() > most_open;
    if (!too_many && held_bytes_ + more_bytes <= settings_.max_held_bytes) return;
    auto idle = transactions_.end();
    for (auto it = transactions_.begin(); it != transactions_.end(); ++it) {
      if (it->first == but || (!too_many && it->second.segments.memory_bytes() == 0)) continue;
      if (idle == transactions_.end() || it->second.received_s < idle->second.received_s) idle = it;
    }
    if (idle == transactions_.end()) return;
    if (idle->second.finished) {
      close(idle->first);
      continue;
    }
    drop_data(idle->second);
    transactions_.erase(idle);
    ++counts_.forgotten;
  }
}

CfdpReceiver::Transaction& CfdpReceiver::begin(const Key& key, double now) {
  const auto found = transactions_.find(key);
  if (found != transactions_.end()) return found->second;
  make_room(key, settings_.max_open - 1, 0);
  Transaction& t = transactions_[key];
  t.next_s = now + settings_.timer_s;
  return t;
}

void CfdpReceiver::restart(Transaction& t) {
  drop_data(t);
  const Transaction old = std::exchange(t, Transaction{});
  t.header = old.header;
  t.received_s = old.received_s;
  ++counts_.restarted;
}

/// Whether the PDU belongs to an ended transaction; if so, it is answered.
bool CfdpReceiver::is_over(const Key& key, const Pdu& pdu) {
  const auto found = closed_.find(key);
  if (found == closed_.end()) return false;
  const Closed& over = found->second;
  bool another = false;
  if (pdu.kind == PduKind::metadata) another = over.metadata != metadata_of(pdu.metadata);
  if (pdu.kind == PduKind::eof && pdu.eof.condition == Condition::no_error) {
    another = over.eof && over.eof != FileEnd{pdu.eof.checksum, pdu.eof.file_bytes};
  }
  if (another) {
    closed_order_.erase(std::find(closed_order_.begin(), closed_order_.end(), key));
    closed_.erase(found);
    ++counts_.restarted;
    return false;
  }
  if (pdu.kind == PduKind::eof) {
    acknowledge_eof(pdu.header, pdu.eof, cfdp::TransactionStatus::terminated);
    if (pdu.eof.condition == Condition::no_error) send_finished(pdu.header, over.answer);
  }
  return true;
}

void CfdpReceiver::receive_metadata(Transaction& t, const cfdp::Metadata& metadata, double now) {
  const FileMetadata reported = metadata_of(metadata);
  if (t.metadata == reported) return;
  if (t.metadata) restart(t);
  t.metadata = reported;
  if (reported.file_bytes > settings_.max_file_bytes) {
    finish(t, Condition::file_size_error, FileStatus::discarded, now);
  } else if (!is_checksum_type(reported.checksum_type)) {
    finish(t, Condition::unsupported_checksum_type, FileStatus::discarded, now);
  }
}

void CfdpReceiver::receive_data(const Key& key, Transaction& t, const cfdp::FileData& data, double now) {
  const std::uint64_t size = data.bytes.size(), most = t.eof ? t.eof->file_bytes : settings_.max_file_bytes;
  counts_.data_bytes += size;
  if (size > most || data.offset > most - size) {
    ++counts_.out_of_range;
    return;
  }
  const std::uint64_t before = t.end;
  t.end = std::max(t.end, data.offset + size);
  if (!t.metadata && settings_.forget_data_before_metadata) return;
  // The octets and the bookkeeping of one piece, so that a file in small pieces is bounded too.
  make_room(key, settings_.max_open, size + 256);
  const std::uint64_t held = t.segments.memory_bytes();
  if (held_bytes_ + size + 256 > settings_.max_held_bytes) return;
  counts_.repeated_bytes += size - t.segments.add(data.offset, data.bytes);
  held_bytes_ += t.segments.memory_bytes() - held;
  if (settings_.immediate_nak && data.offset > before) send_naks(t, before);
  t.next_s = now + settings_.timer_s;
}

void CfdpReceiver::receive_eof(Transaction& t, const cfdp::EndOfFile& eof, double now) {
  acknowledge_eof(t.header, eof, cfdp::TransactionStatus::active);
  if (eof.condition != Condition::no_error) {
    if (!t.finished) finish(t, eof.condition, FileStatus::discarded, now);
    return;
  }
  const FileEnd reported{eof.checksum, eof.file_bytes};
  // A transaction that was cancelled before its EOF came is answered by its Finished.
  if (t.eof == reported || (t.finished && !t.eof)) {
    if (!t.finished) t.next_s = now + settings_.timer_s;
    return;
  }
  if (t.eof) restart(t);
  t.eof = reported;
  const bool possible = t.end <= reported.file_bytes && reported.file_bytes <= settings_.max_file_bytes;
  if (!possible) return finish(t, Condition::file_size_error, FileStatus::discarded, now);
  send_naks(t, 0);
  t.next_s = now + settings_.timer_s;
}

void CfdpReceiver::finish(Transaction& t, Condition condition, FileStatus status, double now) {
  drop_data(t);
  t.finished = true;
  t.answer = {condition, status != FileStatus::retained, status, {}};
  t.next_s = now + settings_.timer_s;
  t.repeats = 0;
  send_finished(t.header, t.answer);
}

void CfdpReceiver::complete_if_whole(Transaction& t, double now) {
  if (!t.metadata || !t.eof || t.finished || !t.segments.whole(t.eof->file_bytes)) return;
  const Bytes file = t.segments.file(t.eof->file_bytes);
  if (!checksum_agrees(t.metadata->checksum_type, file, t.eof->checksum)) {
    ++counts_.checksum_failures;
    return finish(t, Condition::file_checksum_failure, FileStatus::discarded, now);
  }
  if (!keep_(t.metadata->name, file)) {
    return finish(t, Condition::filestore_rejection, FileStatus::rejected_by_filestore, now);
  }
  ++counts_.files;
  finish(t, Condition::no_error, FileStatus::retained, now);
}

/// Takes PDUs that begin no transaction.
void CfdpReceiver::receive_about(const Key& key, const Pdu& pdu) {
  const auto found = transactions_.find(key);
  if (found == transactions_.end()) return;
  const Transaction& t = found->second;
  if (pdu.kind == PduKind::prompt && !t.finished) send_naks(t, 0);
  if (pdu.kind == PduKind::ack && t.finished) close(key);
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
  if (pdu.kind == PduKind::ack || pdu.kind == PduKind::prompt) return receive_about(key, pdu);
  if (is_over(key, pdu)) return;
  Transaction& t = begin(key, now);
  t.header = pdu.header;
  t.received_s = now;
  t.repeats = 0;
  if (pdu.kind == PduKind::eof) receive_eof(t, pdu.eof, now);
  if (pdu.kind == PduKind::metadata) receive_metadata(t, pdu.metadata, now);
  if (t.finished) return;
  if (pdu.kind == PduKind::file_data) receive_data(key, t, pdu.file_data, now);
  complete_if_whole(t, now);
}

void CfdpReceiver::tick(double now) {
  std::vector<Key> over;
  for (auto& [key, t] : transactions_) {
    if (now < t.next_s || (!t.eof && !t.finished)) continue;
    t.next_s = now + settings_.timer_s;
    const bool enough = ++t.repeats > settings_.limit;
    if (t.finished) {
      send_finished(t.header, t.answer);
      if (enough) over.push_back(key);
    } else if (enough) {
      ++counts_.abandoned;
      finish(t, Condition::nak_limit_reached, FileStatus::discarded, now);
    } else {
      send_naks(t, 0);
    }
  }
  for (const Key& key : over) close(key);
}

void CfdpReceiver::cancel_all(double now) {
  for (auto& [key, t] : transactions_) {
    if (!t.finished) finish(t, Condition::cancel_request_received, FileStatus::discarded, now);
  }
}

}  // namespace ilp::ground_cfdp
