#include "fsw/packets/cfdp_pdu.hpp"

#include <iterator>

#include "fsw/base/argument.hpp"
#include "fsw/base/big_endian.hpp"
#include "fsw/packets/bytes.hpp"
#include "fsw/packets/crc16.hpp"

namespace ilp::cfdp {
namespace {

constexpr std::uint8_t version = 1;
constexpr std::size_t fixed_header_bytes = 4;
constexpr std::size_t crc_bytes = 2;

// Directive codes (table 5-4).
constexpr std::uint8_t code_eof = 0x04;
constexpr std::uint8_t code_finished = 0x05;
constexpr std::uint8_t code_ack = 0x06;
constexpr std::uint8_t code_metadata = 0x07;
constexpr std::uint8_t code_nak = 0x08;
constexpr std::uint8_t code_prompt = 0x09;
constexpr std::uint8_t code_keep_alive = 0x0C;

constexpr std::size_t size_width(const Header& header) {
  return header.large_file ? 8 : 4;
}

/// Reads a length of one octet and that many octets.
std::span<const std::uint8_t> take_counted(ByteReader& reader) {
  return reader.take(reader.u8());
}
std::span<const std::uint8_t> take_all(ByteReader& reader) {
  return reader.take(reader.left());
}

PduFault read_options(ByteReader& reader, std::span<const std::uint8_t>& options) {
  if (!reader.ok()) return PduFault::field_cut;
  options = take_all(reader);
  std::span<const std::uint8_t> rest = options;
  Tlv tlv;
  while (next_tlv(rest, tlv)) continue;  // bound: the octets of the options
  return rest.empty() ? PduFault::none : PduFault::tlv_cut;
}

PduFault end_of(const ByteReader& reader) {
  if (!reader.ok()) return PduFault::field_cut;
  return reader.left() == 0 ? PduFault::none : PduFault::trailing_octets;
}

PduFault read_metadata(ByteReader& reader, const Header& header, Metadata& metadata) {
  const std::uint8_t flags = reader.u8();
  metadata.closure_requested = (flags & 0x40U) != 0;
  metadata.checksum_type = flags & 0x0FU;
  metadata.file_bytes = reader.number(size_width(header));
  metadata.source_name = take_counted(reader);
  metadata.destination_name = take_counted(reader);
  return read_options(reader, metadata.options);
}

PduFault read_file_data(ByteReader& reader, const Header& header, FileData& data) {
  data = {};
  if (header.segment_metadata) {
    const std::uint8_t octet = reader.u8();
    data.continuation = octet >> 6U;
    data.segment_metadata = reader.take(octet & 0x3FU);
  }
  data.offset = reader.number(size_width(header));
  if (!reader.ok()) return PduFault::field_cut;
  data.bytes = take_all(reader);
  return PduFault::none;
}

PduFault read_eof(ByteReader& reader, const Header& header, EndOfFile& eof) {
  eof.condition = static_cast<Condition>(reader.u8() >> 4U);
  eof.checksum = static_cast<std::uint32_t>(reader.number(4));
  eof.file_bytes = reader.number(size_width(header));
  return read_options(reader, eof.options);
}

PduFault read_finished(ByteReader& reader, Finished& finished) {
  const std::uint8_t octet = reader.u8();
  finished.condition = static_cast<Condition>(octet >> 4U);
  finished.incomplete = (octet & 0x04U) != 0;
  finished.file_status = static_cast<FileStatus>(octet & 0x03U);
  return read_options(reader, finished.options);
}

PduFault read_ack(ByteReader& reader, Ack& ack) {
  const std::uint8_t directive = reader.u8();
  const std::uint8_t state = reader.u8();
  const std::uint8_t code = directive >> 4U;
  ack.of_finished = code == code_finished;
  ack.condition = static_cast<Condition>(state >> 4U);
  ack.status = static_cast<TransactionStatus>(state & 0x03U);
  const PduFault end = end_of(reader);
  if (end != PduFault::none) return end;
  return code == code_eof || code == code_finished ? PduFault::none : PduFault::acknowledges_nothing;
}

PduFault read_nak(ByteReader& reader, const Header& header, Nak& nak) {
  const std::size_t width = size_width(header);
  nak.scope.begin = reader.number(width);
  nak.scope.end = reader.number(width);
  if (!reader.ok()) return PduFault::field_cut;
  nak.gaps = take_all(reader);
  return nak.gaps.size() % (2 * width) == 0 ? PduFault::none : PduFault::field_cut;
}

PduFault read_directive(ByteReader& reader, Pdu& pdu) {
  if (reader.left() == 0) return PduFault::directive_missing;
  const Header& header = pdu.header;
  switch (reader.u8()) {
    case code_eof:
      pdu.kind = PduKind::eof;
      return read_eof(reader, header, pdu.eof);
    case code_finished:
      pdu.kind = PduKind::finished;
      return read_finished(reader, pdu.finished);
    case code_ack:
      pdu.kind = PduKind::ack;
      return read_ack(reader, pdu.ack);
    case code_metadata:
      pdu.kind = PduKind::metadata;
      return read_metadata(reader, header, pdu.metadata);
    case code_nak:
      pdu.kind = PduKind::nak;
      return read_nak(reader, header, pdu.nak);
    case code_prompt:
      pdu.kind = PduKind::prompt;
      pdu.prompt.keep_alive = (reader.u8() & 0x80U) != 0;
      return end_of(reader);
    case code_keep_alive:
      pdu.kind = PduKind::keep_alive;
      pdu.keep_alive.progress_bytes = reader.number(size_width(header));
      return end_of(reader);
    default:
      return PduFault::directive_unknown;
  }
}

PduFault read_pdu(std::span<const std::uint8_t> bytes, Pdu& pdu) {
  if (bytes.size() < fixed_header_bytes) return PduFault::header_cut;
  if (bytes[0] >> 5U != version) return PduFault::version;
  Header& header = pdu.header;
  const bool is_file_data = (bytes[0] & 0x10U) != 0;
  header.toward_sender = (bytes[0] & 0x08U) != 0;
  header.unacknowledged = (bytes[0] & 0x04U) != 0;
  header.crc = (bytes[0] & 0x02U) != 0;
  header.large_file = (bytes[0] & 0x01U) != 0;
  const std::size_t data_bytes = load_big_endian(&bytes[1], 2);
  header.record_boundaries = (bytes[3] & 0x80U) != 0;
  header.id_length = static_cast<std::uint8_t>(((bytes[3] >> 4U) & 0x07U) + 1);
  header.segment_metadata = (bytes[3] & 0x08U) != 0;
  header.sequence_length = static_cast<std::uint8_t>((bytes[3] & 0x07U) + 1);
  const std::size_t head = header_bytes(header);
  if (bytes.size() < head) return PduFault::header_cut;
  if (bytes.size() != head + data_bytes) return PduFault::length;
  ByteReader ids(bytes.subspan(fixed_header_bytes, head - fixed_header_bytes));
  header.source = ids.number(header.id_length);
  header.sequence = ids.number(header.sequence_length);
  header.destination = ids.number(header.id_length);
  std::span<const std::uint8_t> data = bytes.subspan(head);
  if (header.crc) {
    if (data.size() < crc_bytes) return PduFault::length;
    if (crc16(bytes) != 0) return PduFault::crc;
    data = data.first(data.size() - crc_bytes);
  }
  ByteReader reader(data);
  if (!is_file_data) return read_directive(reader, pdu);
  pdu.kind = PduKind::file_data;
  return read_file_data(reader, header, pdu.file_data);
}

/// Writes consecutive fields. `full` is set when one does not fit, `unfit` when a value does not fit its field.
class Writer {
 public:
  explicit Writer(std::span<std::uint8_t> out) : out_(out) {}

  void number(std::uint64_t value, std::size_t width) {
    if (width < 8 && (value >> (8 * width)) != 0) unfit_ = true;
    if (!capacity(width)) return;
    store_big_endian(value, width, out_.data() + size_);
    size_ += width;
  }
  void octet(unsigned value) { number(value, 1); }
  void bytes(std::span<const std::uint8_t> from) {
    if (!capacity(from.size())) return;
    for (std::size_t i = 0; i < from.size(); ++i) out_[size_ + i] = from[i];
    size_ += from.size();
  }
  void counted(std::span<const std::uint8_t> from) {
    number(from.size(), 1);
    bytes(from);
  }
  void nibbles(unsigned high, unsigned low) {
    if (high > 15 || low > 15) unfit_ = true;
    octet(((high & 15U) << 4U) | (low & 15U));
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool full() const { return full_; }
  [[nodiscard]] bool unfit() const { return unfit_; }

 private:
  bool capacity(std::size_t count) {
    full_ = full_ || out_.size() - size_ < count;
    return !full_;
  }

  std::span<std::uint8_t> out_;
  std::size_t size_ = 0;
  bool full_ = false;
  bool unfit_ = false;
};

void write_header(const Pdu& pdu, Writer& writer) {
  const Header& header = pdu.header;
  unsigned first = static_cast<unsigned>(version) << 5U;
  if (pdu.kind == PduKind::file_data) first |= 0x10U;
  if (header.toward_sender) first |= 0x08U;
  if (header.unacknowledged) first |= 0x04U;
  if (header.crc) first |= 0x02U;
  if (header.large_file) first |= 0x01U;
  writer.octet(first);
  writer.number(0, 2);
  unsigned lengths = (header.id_length - 1U) << 4U | (header.sequence_length - 1U);
  if (header.record_boundaries) lengths |= 0x80U;
  if (header.segment_metadata) lengths |= 0x08U;
  writer.octet(lengths);
  writer.number(header.source, header.id_length);
  writer.number(header.sequence, header.sequence_length);
  writer.number(header.destination, header.id_length);
}

void write_metadata(const Metadata& metadata, std::size_t width, Writer& writer) {
  writer.octet(code_metadata);
  writer.nibbles(metadata.closure_requested ? 4 : 0, metadata.checksum_type);
  writer.number(metadata.file_bytes, width);
  writer.counted(metadata.source_name);
  writer.counted(metadata.destination_name);
  writer.bytes(metadata.options);
}

void write_file_data(const FileData& data, const Header& header, Writer& writer) {
  if (header.segment_metadata) {
    const std::size_t length = data.segment_metadata.size();
    writer.number(length > 63 || data.continuation > 3 ? 256 : (unsigned{data.continuation} << 6U) | length, 1);
    writer.bytes(data.segment_metadata);
  }
  writer.number(data.offset, size_width(header));
  writer.bytes(data.bytes);
}

void write_data_field(const Pdu& pdu, Writer& writer) {
  const std::size_t width = size_width(pdu.header);
  switch (pdu.kind) {
    case PduKind::metadata:
      return write_metadata(pdu.metadata, width, writer);
    case PduKind::file_data:
      return write_file_data(pdu.file_data, pdu.header, writer);
    case PduKind::eof:
      writer.octet(code_eof);
      writer.nibbles(static_cast<unsigned>(pdu.eof.condition), 0);
      writer.number(pdu.eof.checksum, 4);
      writer.number(pdu.eof.file_bytes, width);
      return writer.bytes(pdu.eof.options);
    case PduKind::finished:
      writer.octet(code_finished);
      writer.nibbles(static_cast<unsigned>(pdu.finished.condition),
                     (pdu.finished.incomplete ? 4U : 0U) | static_cast<unsigned>(pdu.finished.file_status));
      return writer.bytes(pdu.finished.options);
    case PduKind::ack:
      writer.octet(code_ack);
      writer.nibbles(pdu.ack.of_finished ? code_finished : code_eof, pdu.ack.of_finished ? 1 : 0);
      return writer.nibbles(static_cast<unsigned>(pdu.ack.condition), static_cast<unsigned>(pdu.ack.status));
    case PduKind::nak:
      writer.octet(code_nak);
      writer.number(pdu.nak.scope.begin, width);
      writer.number(pdu.nak.scope.end, width);
      return writer.bytes(pdu.nak.gaps);
    case PduKind::prompt:
      writer.octet(code_prompt);
      return writer.octet(pdu.prompt.keep_alive ? 0x80U : 0U);
    case PduKind::keep_alive:
      writer.octet(code_keep_alive);
      return writer.number(pdu.keep_alive.progress_bytes, width);
    case PduKind::count:
      break;
  }
}

}  // namespace

Status decode(std::span<const std::uint8_t> bytes, Pdu& pdu) {
  const PduFault fault = read_pdu(bytes, pdu);
  if (fault == PduFault::none) return {};
  return {StatusCode::pdu_rejected, static_cast<std::int64_t>(fault), static_cast<std::int64_t>(bytes.size())};
}

Status encode(const Pdu& pdu, std::span<std::uint8_t> out, std::size_t& bytes) {
  const Header& header = pdu.header;
  if (header.id_length < 1 || header.id_length > 8) return out_of_range(Argument::id_length, header.id_length);
  if (header.sequence_length < 1 || header.sequence_length > 8) {
    return out_of_range(Argument::sequence_length, header.sequence_length);
  }
  if (pdu.kind >= PduKind::count) return out_of_range(Argument::pdu_kind, static_cast<std::uint8_t>(pdu.kind));
  Writer writer(out);
  write_header(pdu, writer);
  write_data_field(pdu, writer);
  const std::size_t crc_place = writer.size();
  if (header.crc) writer.number(0, crc_bytes);
  if (writer.unfit()) return out_of_range(Argument::pdu_field);
  const std::size_t data_bytes = writer.size() - (writer.full() ? 0 : header_bytes(header));
  if (writer.full() || data_bytes > 0xFFFF) {
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(data_bytes),
            static_cast<std::int64_t>(out.size())};
  }
  store_big_endian(data_bytes, 2, &out[1]);
  if (header.crc) store_big_endian(crc16(out.first(crc_place)), crc_bytes, &out[crc_place]);
  bytes = writer.size();
  return {};
}

std::size_t header_bytes(const Header& header) {
  return fixed_header_bytes + 2 * std::size_t{header.id_length} + header.sequence_length;
}

std::size_t gap_count(const Header& header, const Nak& nak) {
  return nak.gaps.size() / (2 * size_width(header));
}

Gap gap_at(const Header& header, const Nak& nak, std::size_t index) {
  const std::size_t width = size_width(header);
  if (index >= gap_count(header, nak)) return {};
  const std::uint8_t* at = nak.gaps.data() + 2 * width * index;
  return {load_big_endian(at, width), load_big_endian(at + width, width)};
}

std::size_t write_gap(const Header& header, const Gap& gap, std::uint8_t* to) {
  const std::size_t width = size_width(header);
  store_big_endian(gap.begin, width, to);
  store_big_endian(gap.end, width, to + width);
  return 2 * width;
}

bool next_tlv(std::span<const std::uint8_t>& rest, Tlv& tlv) {
  if (rest.size() < 2 || rest.size() - 2 < rest[1]) return false;
  tlv.type = rest[0];
  tlv.value = rest.subspan(2, rest[1]);
  rest = rest.subspan(2 + tlv.value.size());
  return true;
}

std::size_t write_fault_location(std::uint64_t entity, std::uint8_t id_length, std::span<std::uint8_t, 10> to) {
  const std::size_t width = id_length <= 8 ? id_length : 8;
  to[0] = tlv_entity_id;
  to[1] = static_cast<std::uint8_t>(width);
  store_big_endian(entity, width, &to[2]);
  return 2 + width;
}

}  // namespace ilp::cfdp
