// Collects the parameters of a statement in the server's binary format (big-endian).
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace ilp::postgres {

/// Numbers are copied. Bytes are not copied and must stay valid until the statement is sent.
class Parameters {
 public:
  static constexpr std::size_t capacity = 256;

  Parameters& add(std::int64_t value) { return number(static_cast<std::uint64_t>(value)); }
  // Every backend stores -0 as 0.
  Parameters& add(double value) { return number(std::bit_cast<std::uint64_t>(value == 0 ? 0.0 : value)); }
  Parameters& add(float value) { return number(std::bit_cast<std::uint32_t>(value == 0 ? 0.0F : value)); }
  Parameters& add_bytes(const void* bytes, std::size_t size) {
    // No pointer would mean NULL.
    return value(size == 0 ? "" : static_cast<const char*>(bytes), size);
  }

  [[nodiscard]] int count() const { return static_cast<int>(count_); }
  [[nodiscard]] bool overflow() const { return overflow_; }
  [[nodiscard]] const char* const* values() const { return values_.data(); }
  [[nodiscard]] const int* lengths() const { return lengths_.data(); }

 private:
  template <typename Unsigned>
  Parameters& number(Unsigned bits) {
    if (count_ == capacity) return value(nullptr, 0);
    auto& place = numbers_[count_];
    for (std::size_t i = 0; i < sizeof(bits); ++i) {
      place[i] = static_cast<char>(static_cast<std::uint8_t>(bits >> (8 * (sizeof(bits) - 1 - i))));
    }
    return value(place.data(), sizeof(bits));
  }
  Parameters& value(const char* bytes, std::size_t size) {
    overflow_ = overflow_ || count_ == capacity;
    if (overflow_) return *this;
    values_[count_] = bytes;
    lengths_[count_++] = static_cast<int>(size);
    return *this;
  }

  std::array<std::array<char, 8>, capacity> numbers_;
  std::array<const char*, capacity> values_;
  std::array<int, capacity> lengths_;
  std::size_t count_ = 0;
  bool overflow_ = false;
};

}  // namespace ilp::postgres
