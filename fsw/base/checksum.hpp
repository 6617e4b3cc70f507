// A fast 64-bit checksum for megabytes of memory, and a copy with a checksum for what is small and must not be lost.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

namespace ilp {

/// Every change within one aligned word of 8 bytes is noticed for certain, any other one but for one in 2^64. Goes on
/// from `before`. Not against intent.
[[nodiscard]] std::uint64_t checksum64(std::span<const std::byte> bytes, std::uint64_t before = 0);

template <typename T>
[[nodiscard]] std::span<const std::byte> memory_of(const T& thing) {
  static_assert(std::is_trivially_copyable_v<T>);
  return {reinterpret_cast<const std::byte*>(&thing), sizeof(T)};
}

/// A part of one object: from `begin` up to `end`.
[[nodiscard]] inline std::span<const std::byte> memory_between(const void* begin, const void* end) {
  const auto* const first = static_cast<const std::byte*>(begin);
  return {first, static_cast<std::size_t>(static_cast<const std::byte*>(end) - first)};
}

enum class GuardFinding : std::uint8_t {
  intact,
  mended,  ///< has its bytes back from the copy
  lost     ///< the copy is not what it was either: nothing was changed
};

/// Keeps a copy of a thing that is to change at known places only.
template <typename T>
class Guarded {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  /// This is what it has to be from now on.
  void seal(const T& thing) {
    std::memcpy(copy_.data(), &thing, sizeof(T));
    sum_ = checksum64(memory_of(thing));
  }
  /// Behind seal().
  [[nodiscard]] GuardFinding check(T& thing) {
    if (checksum64(memory_of(thing)) == sum_) return GuardFinding::intact;
    if (checksum64(copy_) == sum_) {
      std::memcpy(static_cast<void*>(&thing), copy_.data(), sizeof(T));
      return GuardFinding::mended;
    }
    // Two alike out of three: it was the checksum that changed.
    if (std::memcmp(copy_.data(), memory_of(thing).data(), sizeof(T)) != 0) return GuardFinding::lost;
    seal(thing);
    return GuardFinding::intact;
  }

 private:
  alignas(8) std::array<std::byte, sizeof(T)> copy_{};
  std::uint64_t sum_ = 0;
};

}  // namespace ilp
