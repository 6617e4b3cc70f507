// Reads and writes `.ilp` files of the outbox: records with their blobs (docs/outbox.md).
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

#include "fsw/records/records.hpp"
#include "fsw/records/serial.hpp"
#include "sim/ground/intake/coded_file.hpp"

namespace ilp::intake {

/// A downlinked file is not valid; what() says why, in words for the operator.
struct BadFile : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct RecordEntry {
  RecordType type = RecordType::count;
  std::vector<std::uint8_t> serial;  ///< as serialize() wrote it
  std::vector<CodedFile> blobs;      ///< in field order
};

/// Returns the records of a file. Throws BadFile if any part of it is invalid.
[[nodiscard]] std::vector<RecordEntry> parse_record_file(std::span<const std::uint8_t> file);
[[nodiscard]] std::vector<std::uint8_t> write_record_file(std::span<const RecordEntry> entries);

template <typename Record>
[[nodiscard]] Record record_of(const RecordEntry& entry) {
  Record record;
  const Status status = deserialize(record_info<Record>(), entry.serial, &record);
  if (!status.ok()) throw BadFile("record shorter than its type");
  return record;
}

/// Serialises a record. Its blob fields must have the sizes of `blobs`.
template <typename Record>
[[nodiscard]] RecordEntry entry_of(const Record& record, std::vector<CodedFile> blobs = {}) {
  const RecordInfo& info = record_info<Record>();
  RecordEntry entry{info.type, std::vector<std::uint8_t>(serial_bytes(info)), std::move(blobs)};
  const Status status = serialize(info, &record, entry.serial);
  if (!status.ok()) throw std::logic_error("record does not fit its own size");
  return entry;
}

}  // namespace ilp::intake
