// Records as bytes, in the layout of their field tables: every field little-endian in table order, text as its fixed
// capacity, blobs as their 32-bit size (their bytes follow the record, in field order, where the carrier says so).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"
#include "fsw/records/field.hpp"

namespace ilp {

[[nodiscard]] std::size_t serial_bytes(const RecordInfo& info);
/// `capacity_exceeded` when `bytes` is smaller than serial_bytes.
Status serialize(const RecordInfo& info, const void* record, std::span<std::uint8_t> bytes);
/// Total over hostile input: text is terminated, and any other bits are a number. `truncated` when bytes are missing.
Status deserialize(const RecordInfo& info, std::span<const std::uint8_t> bytes, void* record);

}  // namespace ilp
