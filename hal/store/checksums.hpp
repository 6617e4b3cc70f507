// CRC-32C checksums of stored records and of the chunks of blobs. They are the same in every backend.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <type_traits>

#include "cfg/limits.hpp"
#include "fsw/base/crc.hpp"
#include "fsw/base/little_endian.hpp"
#include "fsw/records/field.hpp"
#include "hal/store/record_bytes.hpp"
#include "hal/store/store.hpp"

namespace ilp {
namespace detail {

/// Writes the canonical form of a field and returns its length. The form is the same for all values that a backend may
/// return for one value that was put.
inline std::size_t canonical_field(const FieldInfo& field, const std::uint8_t* from, std::uint8_t* to) {
  if (field.type == FieldType::text) {
    const auto length = strnlen(reinterpret_cast<const char*>(from), field.count - 1U);
    std::memcpy(to, from, length);
    std::memset(to + length, 0, field.count - length);
    return field.count;
  }
  const std::size_t size = element_bytes(field.type);
  for (std::size_t i = 0; i < field.count; ++i, from += size, to += size) {
    visit_number(field.type, from, [to](auto number) {
      using Number = decltype(number);
      if constexpr (std::is_floating_point_v<Number>) {
        // All NaNs become one, and so do the two zeros.
        if (number != number) number = std::numeric_limits<Number>::quiet_NaN();
        if (number == 0) number = 0;
        using Bits = std::conditional_t<sizeof(number) == 4, std::uint32_t, std::uint64_t>;
        store_little_endian(std::bit_cast<Bits>(number), to);
      } else {
        store_little_endian(static_cast<std::make_unsigned_t<Number>>(number), to);
      }
    });
  }
  return size * field.count;
}

}  // namespace detail

/// Returns the checksum of the record's type and all fields. All NaNs are equal, 0 and -0 are equal, and texts end at
/// their terminator.
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

/// Identity of a blob. Its checksums include the identity, so that a chunk of another blob is detected.
struct BlobName {
  RecordType type = RecordType::count;
  std::size_t index = 0;  ///< index of the blob field among the record's blob fields
  std::int64_t id = 0;    ///< id of the record
  std::size_t bytes = 0;  ///< size of the blob
};

[[nodiscard]] constexpr std::size_t chunk_count(std::size_t blob_bytes) {
  return (blob_bytes + blob_chunk_bytes - 1) / blob_chunk_bytes;
}

/// Computes the checksum of a chunk from its parts in their order. The stored checksum 0 stands for a chunk of zeros
/// that was never written, so that a new blob needs no work; value() is never 0.
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
  /// Whether the chunk has the stored checksum.
  [[nodiscard]] bool matches(std::uint32_t stored) const { return stored == 0 ? zeros_ : stored == value(); }

 private:
  std::uint32_t crc_;
  bool zeros_ = true;
};

}  // namespace ilp
