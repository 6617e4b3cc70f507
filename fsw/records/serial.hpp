// The serial form of records. The fields follow in the order of their table, little-endian and without padding. A text
// has its full capacity. A blob is its size in 4 octets; its bytes follow the record, in the order of fields, if the
// format of the file or message says so.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"
#include "fsw/records/field.hpp"

namespace ilp {

/// Size of the serial form, without the bytes of blobs.
[[nodiscard]] std::size_t serial_bytes(const RecordInfo& info);
/// Writes a record. Returns `capacity_exceeded` if `bytes` is smaller than serial_bytes().
Status serialize(const RecordInfo& info, const void* record, std::span<std::uint8_t> bytes);
/// Reads a record. Any bytes are accepted: texts are terminated, and all other bits are numbers. Returns `truncated` if
/// bytes are missing.
Status deserialize(const RecordInfo& info, std::span<const std::uint8_t> bytes, void* record);

}  // namespace ilp
