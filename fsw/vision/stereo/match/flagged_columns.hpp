// Visits the few columns of a row that need work; several flags are tested at a time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace ilp {

/// Calls `use(x)` for each column x in begin .. end - 1 with `flag(x)` = 1, from left to right. The flags of up to 64
/// columns are read before the first `use(x)` among them, so `use(x)` must not change the flags of other columns.
/// `flag` returns 0 or 1 and should not branch.
template <typename Flag, typename Use>
[[gnu::always_inline]] inline void for_each_flagged(std::int32_t begin, std::int32_t end, Flag flag, Use use) {
  constexpr std::int32_t chunk = 64;
  constexpr std::int32_t word_bytes = sizeof(std::uint64_t);
  std::uint8_t flags[chunk];
  for (std::int32_t first = begin; first < end; first += chunk) {
    const std::int32_t count = std::min(end - first, chunk);
    for (std::int32_t i = 0; i < count; ++i) flags[i] = static_cast<std::uint8_t>(flag(first + i));
    std::fill(flags + count, flags + chunk, std::uint8_t{0});
    std::uint64_t words[chunk / word_bytes];
    std::memcpy(words, flags, sizeof words);
    std::uint64_t any = 0;
    for (const std::uint64_t word : words) any |= word;
    if (any == 0) continue;
    for (std::int32_t k = 0; k < chunk; k += word_bytes) {
      if (words[k / word_bytes] == 0) continue;
      for (std::int32_t i = k; i < k + word_bytes; ++i) {
        if (flags[i] != 0) use(first + i);
      }
    }
  }
}

}  // namespace ilp
