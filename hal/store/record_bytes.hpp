// Reads ids, numbers and blobs of a record by its field table. All backends of the store use these functions.
#pragma once

#include <cstdint>
#include <cstring>

#include "cfg/limits.hpp"
#include "fsw/records/field.hpp"

namespace ilp {

using limits::max_blob_fields;

/// Returns the id, which is the first field of every record.
[[nodiscard]] inline std::int64_t id_of(const void* record) {
  std::int64_t id = 0;
  std::memcpy(&id, record, sizeof(id));
  return id;
}

/// Returns the size of a blob that the record states, bytes.
[[nodiscard]] inline std::uint32_t blob_bytes(const void* record, const FieldInfo& field) {
  Blob blob;
  std::memcpy(&blob, static_cast<const std::uint8_t*>(record) + field.offset, sizeof(blob));
  return blob.bytes;
}

/// Calls visit(number) with the element at `from`, in the C++ type of the field type, and returns its result. The
/// number of a blob is its size. Not for texts.
template <typename Visit>
auto visit_number(FieldType type, const void* from, Visit visit) {
  const auto as = [&](auto number) {
    std::memcpy(&number, from, sizeof(number));
    return visit(number);
  };
  switch (type) {
    case FieldType::u16:
      return as(std::uint16_t{});
    case FieldType::u32:
    case FieldType::blob:
      return as(std::uint32_t{});
    case FieldType::i32:
      return as(std::int32_t{});
    case FieldType::i64:
      return as(std::int64_t{});
    case FieldType::f32:
      return as(float{});
    case FieldType::f64:
      return as(double{});
    default:
      return as(std::uint8_t{});
  }
}

/// Calls visit(field, index) for the blob fields in order; index counts from 0.
template <typename Visit>
void for_each_blob(const RecordInfo& info, Visit visit) {
  std::size_t index = 0;
  for (std::size_t f = 0; f < info.field_count; ++f) {
    if (info.fields[f].type == FieldType::blob) visit(info.fields[f], index++);
  }
}

/// Sets the sizes of the record's blobs to 0.
inline void drop_blobs(const RecordInfo& info, void* record) {
  for_each_blob(info, [&](const FieldInfo& field, std::size_t) {
    std::memset(static_cast<std::uint8_t*>(record) + field.offset, 0, sizeof(Blob));
  });
}

/// Index of the blob field with this name, counted among the blob fields; max_blob_fields: there is none.
[[nodiscard]] inline std::size_t find_blob(const RecordInfo& info, const char* name) {
  std::size_t found = max_blob_fields;
  for_each_blob(info, [&](const FieldInfo& field, std::size_t index) {
    if (name != nullptr && std::strcmp(field.name, name) == 0) found = index;
  });
  return found;
}

}  // namespace ilp
