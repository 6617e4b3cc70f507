#include "fsw/records/serial.hpp"

#include <cstring>

#include "fsw/base/little_endian.hpp"

namespace ilp {
namespace {

template <typename Unsigned>
void store_as(const void* from, std::uint8_t* to) {
  Unsigned value;
  std::memcpy(&value, from, sizeof(value));
  store_little_endian(value, to);
}

template <typename Unsigned>
void load_as(const std::uint8_t* from, void* to) {
  const Unsigned value = load_little_endian<Unsigned>(from);
  std::memcpy(to, &value, sizeof(value));
}

void store_element(const void* from, std::size_t size, std::uint8_t* to) {
  switch (size) {
    case 2:
      return store_as<std::uint16_t>(from, to);
    case 4:
      return store_as<std::uint32_t>(from, to);
    case 8:
      return store_as<std::uint64_t>(from, to);
    default:
      std::memcpy(to, from, size);
  }
}

void load_element(const std::uint8_t* from, std::size_t size, void* to) {
  switch (size) {
    case 2:
      return load_as<std::uint16_t>(from, to);
    case 4:
      return load_as<std::uint32_t>(from, to);
    case 8:
      return load_as<std::uint64_t>(from, to);
    default:
      std::memcpy(to, from, size);
  }
}

}  // namespace

std::size_t serial_bytes(const RecordInfo& info) {
  std::size_t bytes = 0;
  for (std::size_t f = 0; f < info.field_count; ++f) bytes += element_bytes(info.fields[f].type) * info.fields[f].count;
  return bytes;
}

Status serialize(const RecordInfo& info, const void* record, std::span<std::uint8_t> bytes) {
  const std::size_t needed = serial_bytes(info);
  if (bytes.size() < needed) {
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(needed), static_cast<std::int64_t>(bytes.size())};
  }
  const auto* from = static_cast<const std::uint8_t*>(record);
  std::uint8_t* to = bytes.data();
  for (std::size_t f = 0; f < info.field_count; ++f) {
    const FieldInfo& field = info.fields[f];
    const std::size_t size = element_bytes(field.type);
    for (std::size_t i = 0; i < field.count; ++i, to += size) store_element(from + field.offset + i * size, size, to);
  }
  return {};
}

Status deserialize(const RecordInfo& info, std::span<const std::uint8_t> bytes, void* record) {
  const std::size_t needed = serial_bytes(info);
  if (bytes.size() < needed) {
    return {StatusCode::truncated, static_cast<std::int64_t>(bytes.size()), static_cast<std::int64_t>(needed)};
  }
  auto* to = static_cast<std::uint8_t*>(record);
  const std::uint8_t* from = bytes.data();
  for (std::size_t f = 0; f < info.field_count; ++f) {
    const FieldInfo& field = info.fields[f];
    const std::size_t size = element_bytes(field.type);
    for (std::size_t i = 0; i < field.count; ++i, from += size) load_element(from, size, to + field.offset + i * size);
    if (field.type == FieldType::text) to[field.offset + field.count - 1U] = 0;
  }
  return {};
}

}  // namespace ilp
