// Reads and writes the fields of a map's files: integers and floating-point numbers (IEEE 754, 64 bit), the least
// significant octet first, without padding.
#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/little_endian.hpp"
#include "fsw/base/status.hpp"

namespace ilp::map_file {

/// Returns `parse_error` with the offset.
inline Status fault_at(std::size_t offset) {
  return {StatusCode::parse_error, static_cast<std::int64_t>(offset)};
}

/// Reads fields from front to back. Beyond the end every field is 0, and whole() is false.
class FieldReader {
 public:
  explicit FieldReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  template <std::unsigned_integral Unsigned>
  void read(Unsigned& value) {
    value = 0;
    if (!whole_ || bytes_.size() - at_ < sizeof(value)) {
      whole_ = false;
      return;
    }
    value = load_little_endian<Unsigned>(bytes_.data() + at_);
    at_ += sizeof(value);
  }
  void read(double& value) {
    std::uint64_t bits = 0;
    read(bits);
    value = std::bit_cast<double>(bits);
  }
  void read(std::int32_t& value) {
    std::uint32_t bits = 0;
    read(bits);
    value = static_cast<std::int32_t>(bits);
  }
  std::span<const std::uint8_t> take(std::size_t size) {
    if (!whole_ || bytes_.size() - at_ < size) {
      whole_ = false;
      return {};
    }
    at_ += size;
    return bytes_.subspan(at_ - size, size);
  }
  [[nodiscard]] bool whole() const { return whole_; }
  [[nodiscard]] std::size_t at() const { return at_; }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  bool whole_ = true;
};

/// Writes fields from front to back. Fields that do not fit are not written but counted in size().
class FieldWriter {
 public:
  explicit FieldWriter(std::span<std::uint8_t> bytes) : bytes_(bytes) {}

  template <std::unsigned_integral Unsigned>
  void write(Unsigned value) {
    if (at_ <= bytes_.size() && bytes_.size() - at_ >= sizeof(value)) store_little_endian(value, bytes_.data() + at_);
    at_ += sizeof(value);
  }
  void write(double value) { write(std::bit_cast<std::uint64_t>(value)); }
  void write(std::int32_t value) { write(static_cast<std::uint32_t>(value)); }
  /// The bytes that were not written yet.
  [[nodiscard]] std::span<std::uint8_t> unused() const {
    return at_ < bytes_.size() ? bytes_.subspan(at_) : std::span<std::uint8_t>{};
  }
  void skip(std::size_t size) { at_ += size; }
  [[nodiscard]] std::size_t size() const { return at_; }
  [[nodiscard]] bool fits() const { return at_ <= bytes_.size(); }

 private:
  std::span<std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

}  // namespace ilp::map_file
