// Values that inputs put where numbers stand.
#pragma once

#include <cstdint>
#include <iterator>

namespace ilp::fuzz {

/// Doubles and integers that are easily mistaken for good ones, in octets as they stand in records.
inline std::uint64_t special_value(std::uint8_t choice) {
  static constexpr std::uint64_t values[] = {
      0,                      // also 0.0
      0x7FF8000000000000ULL,  // NaN
      0x7FF0000000000000ULL,  // infinity
      0xFFF0000000000000ULL,
      0x7FEFFFFFFFFFFFFFULL,  // the largest double
      0x0000000000000001ULL,  // denormal, also 1
      0x7FFFFFFFFFFFFFFFULL,
      0x8000000000000000ULL,
      0xFFFFFFFFFFFFFFFFULL,
      0x1000000000000000ULL,  // the largest id
      0x3FF0000000000000ULL,  // 1.0
      0xBFF0000000000000ULL,
      0x4330000000000000ULL,  // 2^52
      0x7F8000007F800000ULL,  // infinity twice, as floats
      0x7FC000007FC00000ULL,
      0x00000001FFFFFFFFULL,
  };
  return values[choice % std::size(values)];
}

}  // namespace ilp::fuzz
