// Deterministic random numbers: PCG32 (M. E. O'Neill, HMC-CS-2014-0905), seeded from record ids.
#pragma once

#include <cstdint>

namespace ilp {

/// Mixes 64 bits (the finaliser of SplitMix64), which makes well-spread seeds from ids.
[[nodiscard]] constexpr std::uint64_t mix64(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27U)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31U);
}

class Rng {
 public:
  /// Users with the same seed and different `stream` get independent numbers.
  explicit constexpr Rng(std::uint64_t seed, std::uint64_t stream = 0) : increment_((mix64(stream) << 1U) | 1U) {
    next();
    state_ += mix64(seed);
    next();
  }

  /// Uniform in [0, 2^32).
  constexpr std::uint32_t next() {
    const std::uint64_t old = state_;
    state_ = old * 6364136223846793005ULL + increment_;
    const auto xorshifted = static_cast<std::uint32_t>(((old >> 18U) ^ old) >> 27U);
    const auto rotation = static_cast<std::uint32_t>(old >> 59U);
    return (xorshifted >> rotation) | (xorshifted << ((32U - rotation) & 31U));
  }

  /// Uniform in [0, bound), bound > 0. The bias of the multiplication method is below bound / 2^32.
  constexpr std::uint32_t below(std::uint32_t bound) {
    return static_cast<std::uint32_t>((static_cast<std::uint64_t>(next()) * bound) >> 32U);
  }

  /// Uniform in [0, 1).
  constexpr double uniform() { return next() * (1.0 / 4294967296.0); }

 private:
  std::uint64_t state_ = 0;
  std::uint64_t increment_;
};

}  // namespace ilp
