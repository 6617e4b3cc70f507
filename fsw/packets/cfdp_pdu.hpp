// Encodes and decodes protocol data units of the CCSDS File Delivery Protocol, class 2 (CCSDS 727.0-B-5, chapter 5).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/enumeration.hpp"
#include "fsw/base/status.hpp"

namespace ilp::cfdp {

enum class PduKind : std::uint8_t { metadata, file_data, eof, finished, ack, nak, prompt, keep_alive, count };

/// Condition code of a transaction (table 5-5).
ILP_ENUMERATION(Condition, (0, no_error, "no error"), (1, ack_limit_reached, "ACK limit reached"),
                (2, keep_alive_limit_reached, "keep alive limit reached"),
                (3, invalid_transmission_mode, "invalid transmission mode"),
                (4, filestore_rejection, "filestore rejection"), (5, file_checksum_failure, "file checksum failure"),
                (6, file_size_error, "file size error"), (7, nak_limit_reached, "NAK limit reached"),
                (8, inactivity_detected, "inactivity detected"), (9, invalid_file_structure, "invalid file structure"),
                (10, check_limit_reached, "check limit reached"),
                (11, unsupported_checksum_type, "unsupported checksum type"),
                (14, suspend_request_received, "suspend request received"),
                (15, cancel_request_received, "cancel request received"))

/// The file's state at the receiver (table 5-7).
enum class FileStatus : std::uint8_t { discarded = 0, rejected_by_filestore = 1, retained = 2, unreported = 3 };

/// Status of the transaction at the entity that sends an ACK (table 5-8).
enum class TransactionStatus : std::uint8_t { undefined = 0, active = 1, terminated = 2, unrecognized = 3 };

/// Fixed header of every PDU of a transaction. Lengths are in octets, from 1 to 8.
struct Header {
  bool toward_sender = false;   ///< direction: false toward the receiver of the file, true toward its sender
  bool unacknowledged = false;  ///< class 1
  bool crc = false;             ///< a CRC follows the data field
  bool large_file = false;      ///< sizes and offsets have 8 octets instead of 4
  bool record_boundaries = false;
  bool segment_metadata = false;
  std::uint8_t id_length = 2;        ///< length of both entity IDs
  std::uint8_t sequence_length = 2;  ///< length of the sequence number
  std::uint64_t source = 0;          ///< entity ID
  std::uint64_t sequence = 0;        ///< transaction sequence number
  std::uint64_t destination = 0;     ///< entity ID
};

/// File names are bytes without a terminator; `options` are complete TLVs: requests to the file store, messages to the
/// user, overrides of fault handlers, flow label.
struct Metadata {
  bool closure_requested = false;
  std::uint8_t checksum_type = 0;
  std::uint64_t file_bytes = 0;
  std::span<const std::uint8_t> source_name;
  std::span<const std::uint8_t> destination_name;
  std::span<const std::uint8_t> options;
};

struct FileData {
  std::uint8_t continuation = 0;  ///< record continuation state, with segment metadata only
  std::span<const std::uint8_t> segment_metadata;
  std::uint64_t offset = 0;
  std::span<const std::uint8_t> bytes;
};

/// `options` holds the fault location, an entity ID as TLV, if the condition is not no_error.
struct EndOfFile {
  Condition condition = Condition::no_error;
  std::uint32_t checksum = 0;
  std::uint64_t file_bytes = 0;
  std::span<const std::uint8_t> options;
};

/// `options` holds responses of the file store and the fault location as TLVs.
struct Finished {
  Condition condition = Condition::no_error;
  bool incomplete = false;
  FileStatus file_status = FileStatus::discarded;
  std::span<const std::uint8_t> options;
};

/// Acknowledges an EOF or a Finished.
struct Ack {
  bool of_finished = false;  ///< false: acknowledges an EOF
  Condition condition = Condition::no_error;
  TransactionStatus status = TransactionStatus::undefined;
};

/// Missing range [begin, end) of the file, in octets. A gap from 0 to 0 requests the metadata.
struct Gap {
  std::uint64_t begin = 0;
  std::uint64_t end = 0;
};

/// Requests the missing parts of `scope`.
struct Nak {
  Gap scope;
  std::span<const std::uint8_t> gaps;  ///< as encoded: begin and end of each gap in 4 octets, in 8 for a large file
};

struct Prompt {
  bool keep_alive = false;  ///< requests a keep-alive; otherwise a NAK
};

struct KeepAlive {
  std::uint64_t progress_bytes = 0;  ///< end of the received data
};

/// One PDU. Beside the header, only the member that `kind` names is valid. Spans point into the decoded bytes.
struct Pdu {
  Header header;
  PduKind kind = PduKind::metadata;
  Metadata metadata;
  FileData file_data;
  EndOfFile eof;
  Finished finished;
  Ack ack;
  Nak nak;
  Prompt prompt;
  KeepAlive keep_alive;
};

/// The reason why bytes are no PDU.
ILP_ENUMERATION(PduFault, (0, none, ""), (1, header_cut, "header cut short"), (2, version, "version"),
                (3, length, "length of the data field"), (4, crc, "CRC"), (5, directive_missing, "no directive code"),
                (6, directive_unknown, "unknown directive code"), (7, field_cut, "field cut short"),
                (8, trailing_octets, "octets after the last field"), (9, tlv_cut, "option cut short"),
                (10, acknowledges_nothing, "ACK of what is never acknowledged"))

/// Decodes one PDU. Any bytes are allowed. Returns `pdu_rejected` (first value: PduFault, second: octets given) if they
/// are no PDU; `pdu` is then undefined. Reserved or redundant fields (spare bits, the direction) are not checked.
Status decode(std::span<const std::uint8_t> bytes, Pdu& pdu);

/// Encodes one PDU; `bytes` gets its length. Returns `capacity_exceeded` if `out` or a field of the PDU is too small,
/// and `invalid_argument` for a value that its field cannot hold, such as a large size without the flag for large
/// files.
Status encode(const Pdu& pdu, std::span<std::uint8_t> out, std::size_t& bytes);

/// Encoded length of the header, in octets.
[[nodiscard]] std::size_t header_bytes(const Header& header);

/// Number of gaps in a NAK.
[[nodiscard]] std::size_t gap_count(const Header& header, const Nak& nak);
/// The gap at `index`, counted from 0; zeros beyond the last gap.
[[nodiscard]] Gap gap_at(const Header& header, const Nak& nak, std::size_t index);
/// Writes one gap for a NAK; returns the octets written: 8 or 16.
std::size_t write_gap(const Header& header, const Gap& gap, std::uint8_t* to);

struct Tlv {
  std::uint8_t type = 0;
  std::span<const std::uint8_t> value;
};
inline constexpr std::uint8_t tlv_entity_id = 6;
/// Takes the first option from the front of `rest`. Returns `false` when none is left.
[[nodiscard]] bool next_tlv(std::span<const std::uint8_t>& rest, Tlv& tlv);
/// Writes the fault location of an EOF or a Finished as a TLV; returns the octets written, at most 10.
std::size_t write_fault_location(std::uint64_t entity, std::uint8_t id_length, std::span<std::uint8_t, 10> to);

}  // namespace ilp::cfdp
