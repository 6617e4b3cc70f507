#include "sim/ground/cfdp/cfdp_sender.hpp"

#include <algorithm>

#include "fsw/base/crc.hpp"

namespace ilp::ground_cfdp {
namespace {

using cfdp::Pdu;
using cfdp::PduKind;

std::uint32_t checksum_of(const CfdpSender::Bytes& file, std::uint8_t type) {
  if (type == 3) return crc32(file);
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < file.size(); ++i) sum += std::uint32_t{file[i]} << (24 - 8 * (i % 4));
  return sum;
}

}  // namespace

void CfdpSender::send(const cfdp::Header& header, Pdu pdu) {
  pdu.header = header;
  Bytes out(4096);
  std::size_t bytes = 0;
  if (!cfdp::encode(pdu, out, bytes).ok()) return;
  out.resize(bytes);
  send_(out);
}

void CfdpSender::send_metadata(const Transfer& transfer) {
  Pdu pdu;
  const auto* name = reinterpret_cast<const std::uint8_t*>(transfer.name.data());
  pdu.metadata.checksum_type = settings_.checksum_type;
  pdu.metadata.file_bytes = transfer.file.size();
  pdu.metadata.source_name = pdu.metadata.destination_name = {name, transfer.name.size()};
  send(transfer.header, pdu);
}

void CfdpSender::send_data(const Transfer& transfer, std::uint64_t begin, std::uint64_t end) {
  end = std::min<std::uint64_t>(end, transfer.file.size());
  for (std::uint64_t at = begin; at < end; at += settings_.segment_bytes) {
    Pdu pdu;
    pdu.kind = PduKind::file_data;
    pdu.file_data.offset = at;
    const std::uint64_t size = std::min<std::uint64_t>(settings_.segment_bytes, end - at);
    pdu.file_data.bytes = std::span(transfer.file).subspan(at, size);
    send(transfer.header, pdu);
  }
}

void CfdpSender::send_eof(const Transfer& transfer) {
  Pdu pdu;
  pdu.kind = PduKind::eof;
  pdu.eof.checksum = checksum_of(transfer.file, settings_.checksum_type);
  pdu.eof.file_bytes = transfer.file.size();
  send(transfer.header, pdu);
}

std::uint64_t CfdpSender::put(const std::string& name, const Bytes& file, double now, std::uint64_t sequence) {
  sequence_ = sequence;
  Transfer transfer;
  transfer.header.crc = settings_.crc;
  transfer.header.id_length = settings_.id_length;
  transfer.header.sequence_length = settings_.sequence_length;
  transfer.header.source = settings_.entity;
  transfer.header.destination = settings_.destination;
  transfer.header.sequence = sequence;
  transfer.name = name;
  transfer.file = file;
  transfer.next_s = now + settings_.timer_s;
  send_metadata(transfer);
  send_data(transfer, 0, file.size());
  send_eof(transfer);
  transfers_[sequence] = transfer;
  return sequence;
}

/// Octets in the gaps of a NAK are sent once, however often the gaps name them.
void CfdpSender::send_again(const Transfer& transfer, const Pdu& pdu) {
  bool metadata = false;
  std::vector<cfdp::Gap> gaps;
  for (std::size_t i = 0; i < cfdp::gap_count(pdu.header, pdu.nak); ++i) {
    gaps.push_back(cfdp::gap_at(pdu.header, pdu.nak, i));
    metadata = metadata || (gaps.back().begin == 0 && gaps.back().end == 0);
  }
  if (metadata) send_metadata(transfer);
  std::sort(gaps.begin(), gaps.end(), [](const cfdp::Gap& a, const cfdp::Gap& b) { return a.begin < b.begin; });
  std::uint64_t sent = 0;
  for (const cfdp::Gap& gap : gaps) {
    send_data(transfer, std::max(gap.begin, sent), gap.end);
    sent = std::max(sent, gap.end);
  }
}

void CfdpSender::receive(std::span<const std::uint8_t> bytes, double now) {
  Pdu pdu;
  if (!cfdp::decode(bytes, pdu).ok() || pdu.header.source != settings_.entity) return;
  const auto found = transfers_.find(pdu.header.sequence);
  if (found == transfers_.end()) return;
  Transfer& transfer = found->second;
  transfer.repeats = 0;
  transfer.next_s = now + settings_.timer_s;
  if (pdu.kind == PduKind::ack && !pdu.ack.of_finished) transfer.eof_acknowledged = true;
  if (pdu.kind == PduKind::nak && transfer.state == State::going) {
    send_again(transfer, pdu);
  }
  if (pdu.kind != PduKind::finished) return;
  const cfdp::Finished& finished = pdu.finished;
  const bool retained = finished.condition == cfdp::Condition::no_error && !finished.incomplete &&
                        finished.file_status == cfdp::FileStatus::retained;
  if (transfer.state == State::going) {
    transfer.state = retained ? State::retained : State::failed;
    transfer.condition = finished.condition;
    transfer.file_status = finished.file_status;
    transfer.file = {};
  }
  Pdu ack;
  ack.kind = PduKind::ack;
  ack.ack = {true, finished.condition, cfdp::TransactionStatus::active};
  send(transfer.header, ack);
}

void CfdpSender::tick(double now) {
  for (auto& [sequence, transfer] : transfers_) {
    if (transfer.state != State::going || now < transfer.next_s) continue;
    transfer.next_s = now + settings_.timer_s;
    if (!transfer.eof_acknowledged) send_eof(transfer);
    if (++transfer.repeats <= settings_.limit) continue;
    transfer.state = State::failed;
    transfer.file = {};
  }
}

}  // namespace ilp::ground_cfdp
