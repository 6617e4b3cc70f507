// The checksums of stored data, the same in every backend: of records and of the chunks of blobs. CRC-32C.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/crc.hpp"
#include "fsw/base/little_endian.hpp"
#include "fsw/records/field.hpp"
#include "hal/store/store.hpp"

namespace ilp {
namespace detail {

template <typename Unsigned>
inline void add_number(const std::uint8_t* from, std::uint8_t* to) {
  Unsigned value;
  std::memcpy(&value, from, sizeof(value));
  store_little_endian(value, to);
}

/// All NaNs become one, and so do the two zeros.
template <typename Float, typename Unsigned>
inline void add_float(const std::uint8_t* from, std::uint8_t* to) {
  static_assert(sizeof(Float) == sizeof(Unsigned));
  Float value;
  std::memcpy(&value, from, sizeof(value));
  if (value != value) value = std::numeric_limits<Float>::quiet_NaN();
  if (value == 0) value = 0;
  store_little_endian(std::bit_cast<Unsigned>(value), to);
}

/// Writes the canonical form of a field, which does not depend on the backend; returns its length.
inline std::size_t canonical_field(const FieldInfo& field, const std::uint8_t* from, std::uint8_t* to) {
  if (field.type == FieldType::text) {
    const auto length = strnlen(reinterpret_cast<const char*>(from), field.count - 1U);
    std::memcpy(to, from, length);
    std::memset(to + length, 0, field.count - length);
    return field.count;
  }
  const std::size_t size = element_bytes(field.type);
  for (std::size_t i = 0; i < field.count; ++i, from += size, to += size) {
    switch (field.type) {
      case FieldType::u16:
        add_number<std::uint16_t>(from, to);
        break;
      case FieldType::u32:
      case FieldType::i32:
      case FieldType::blob:
        add_number<std::uint32_t>(from, to);
        break;
      case FieldType::i64:
        add_number<std::uint64_t>(from, to);
        break;
      case FieldType::f32:
        add_float<float, std::uint32_t>(from, to);
        break;
      case FieldType::f64:
        add_float<double, std::uint64_t>(from, to);
        break;
      default:
        *to = *from;
    }
  }
  return size * field.count;
}

}  // namespace detail

/// Covers the type, the id and all fields. All NaNs are equal, so are the zeros, and texts end at their terminator.
[[nodiscard]] inline std::uint32_t record_checksum(const RecordInfo& info, const void* record) {
  std::uint8_t bytes[limits::max_record_bytes + 1];
  std::size_t size = 0;
  bytes[size++] = static_cast<std::uint8_t>(info.type);
  const auto* const from = static_cast<const std::uint8_t*>(record);
  for (std::size_t f = 0; f < info.field_count; ++f) {
    size += detail::canonical_field(info.fields[f], from + info.fields[f].offset, bytes + size);
  }
  return crc32c({bytes, size});
}

/// The identity of the blob is part of the checked data, so that a chunk in another's place is detected.
struct BlobName {
  RecordType type = RecordType::count;
  std::size_t index = 0;  ///< index of the blob field among the record's
  std::int64_t id = 0;
  std::size_t bytes = 0;  ///< of the whole blob
};

[[nodiscard]] constexpr std::size_t chunk_count(std::size_t blob_bytes) {
  return (blob_bytes + blob_chunk_bytes - 1) / blob_chunk_bytes;
}

/// The checksum of a chunk, computed from its parts in their order. 0 stands for a chunk that was never written and is
/// all zeros, so that a new blob needs no work; no other chunk has it.
class ChunkSum {
 public:
  ChunkSum(const BlobName& blob, std::size_t chunk) {
    std::uint8_t name[2 + 3 * 8];
    name[0] = static_cast<std::uint8_t>(blob.type);
    name[1] = static_cast<std::uint8_t>(blob.index);
    store_little_endian(static_cast<std::uint64_t>(blob.id), name + 2);
    store_little_endian(static_cast<std::uint64_t>(blob.bytes), name + 10);
    store_little_endian(static_cast<std::uint64_t>(chunk), name + 18);
    crc_ = crc32c(name);
  }
  void add(std::span<const std::uint8_t> part) {
    crc_ = crc32c(part, crc_);
    if (zeros_) zeros_ = std::all_of(part.begin(), part.end(), [](std::uint8_t byte) { return byte == 0; });
  }
  [[nodiscard]] std::uint32_t value() const { return crc_ != 0 ? crc_ : 1; }
  [[nodiscard]] bool matches(std::uint32_t stored) const { return stored == 0 ? zeros_ : stored == value(); }

 private:
  std::uint32_t crc_;
  bool zeros_ = true;
};

}  // namespace ilp
