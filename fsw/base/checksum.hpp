// A fast 64-bit checksum for megabytes of memory, and a guarded copy for small data that must not be lost.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

namespace ilp {

/// Checksum of `bytes`, continued from the checksum `before`. It detects every change within one aligned word of 8
/// bytes and misses one in 2^64 of all other changes. It is no protection against deliberate changes.
[[nodiscard]] std::uint64_t checksum64(std::span<const std::byte> bytes, std::uint64_t before = 0);

/// The bytes of an object.
template <typename T>
[[nodiscard]] std::span<const std::byte> memory_of(const T& thing) {
  static_assert(std::is_trivially_copyable_v<T>);
  return {reinterpret_cast<const std::byte*>(&thing), sizeof(T)};
}

/// The bytes of an object from `begin` up to `end`.
[[nodiscard]] inline std::span<const std::byte> memory_between(const void* begin, const void* end) {
  const auto* const first = static_cast<const std::byte*>(begin);
  return {first, static_cast<std::size_t>(static_cast<const std::byte*>(end) - first)};
}

enum class GuardFinding : std::uint8_t {
  intact,
  mended,  ///< the object had changed and was restored from the copy
  lost     ///< object and copy have changed: nothing was restored
};

/// Detects and repairs unintended changes of an object by a copy. The owner calls seal() after each intended change.
template <typename T>
class Guarded {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  /// Takes `thing` as the valid content from now on.
  void seal(const T& thing) {
    std::memcpy(copy_.data(), &thing, sizeof(T));
    sum_ = checksum64(memory_of(thing));
  }
  /// Compares `thing` with the sealed content and restores it if they differ. Call it after seal().
  [[nodiscard]] GuardFinding check(T& thing) {
    if (checksum64(memory_of(thing)) == sum_) return GuardFinding::intact;
    if (checksum64(copy_) == sum_) {
      std::memcpy(static_cast<void*>(&thing), copy_.data(), sizeof(T));
      return GuardFinding::mended;
    }
    // Object and copy agree, so the checksum itself has changed.
    if (std::memcmp(copy_.data(), memory_of(thing).data(), sizeof(T)) != 0) return GuardFinding::lost;
    seal(thing);
    return GuardFinding::intact;
  }

 private:
  alignas(8) std::array<std::byte, sizeof(T)> copy_{};
  std::uint64_t sum_ = 0;
};

}  // namespace ilp
