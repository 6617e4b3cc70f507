// Big-endian numbers in bounded spans, for reading and writing packets.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "fsw/base/big_endian.hpp"

namespace ilp {

/// Reads from front to back. A read beyond the end gives 0 and moves to the end; `ok` stays false from then on.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  /// Reads an unsigned number of `octets` octets, 0 to 8.
  std::uint64_t number(std::size_t octets) {
    if (octets > 8 || octets > left()) {
      fail();
      return 0;
    }
    const std::uint64_t value = load_big_endian(bytes_.data() + at_, octets);
    at_ += octets;
    return value;
  }
  std::uint8_t u8() { return static_cast<std::uint8_t>(number(1)); }
  std::uint16_t u16() { return static_cast<std::uint16_t>(number(2)); }
  std::uint32_t u32() { return static_cast<std::uint32_t>(number(4)); }
  std::int32_t i32() { return static_cast<std::int32_t>(u32()); }
  float f32() { return std::bit_cast<float>(u32()); }
  double f64() { return std::bit_cast<double>(number(8)); }
  /// Takes the next `octets` octets. Returns an empty span, and `ok` becomes false, when fewer are left.
  std::span<const std::uint8_t> take(std::size_t octets) {
    if (octets > left()) {
      fail();
      return {};
    }
    const std::span<const std::uint8_t> part = bytes_.subspan(at_, octets);
    at_ += octets;
    return part;
  }
  /// The octets that were not read yet. They stay unread.
  [[nodiscard]] std::span<const std::uint8_t> rest() const { return bytes_.subspan(at_); }

  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }
  [[nodiscard]] std::size_t offset() const { return at_; }

 private:
  void fail() {
    ok_ = false;
    at_ = bytes_.size();
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

/// Writes from front to back. Data that does not fit is not written; `ok` stays false and nothing is written from then
/// on.
class ByteWriter {
 public:
  explicit ByteWriter(std::span<std::uint8_t> bytes) : bytes_(bytes) {}

  /// Writes `value` in `octets` octets, 0 to 8. Writes nothing, and `ok` becomes false, if the value needs more octets.
  void number(std::uint64_t value, std::size_t octets) {
    const bool fits = octets <= 8 && octets <= left() && (octets == 8 || (value >> (8 * octets)) == 0);
    if (!fits || !ok_) {
      ok_ = false;
      return;
    }
    store_big_endian(value, octets, bytes_.data() + at_);
    at_ += octets;
  }
  void u8(std::uint8_t value) { number(value, 1); }
  void u16(std::uint16_t value) { number(value, 2); }
  void u32(std::uint32_t value) { number(value, 4); }
  void i32(std::int32_t value) { u32(static_cast<std::uint32_t>(value)); }
  void f32(float value) { u32(std::bit_cast<std::uint32_t>(value)); }
  void f64(double value) { number(std::bit_cast<std::uint64_t>(value), 8); }
  void put(std::span<const std::uint8_t> bytes) {
    if (bytes.size() > left() || !ok_) {
      ok_ = false;
      return;
    }
    if (!bytes.empty()) std::memcpy(bytes_.data() + at_, bytes.data(), bytes.size());
    at_ += bytes.size();
  }

  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }
  [[nodiscard]] std::size_t size() const { return at_; }
  [[nodiscard]] std::span<const std::uint8_t> written() const { return bytes_.first(at_); }

 private:
  std::span<std::uint8_t> bytes_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

}  // namespace ilp
