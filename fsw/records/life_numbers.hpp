// The ranges of record ids of the lives of a flight. A life is the content of one database.
#pragma once

#include <cstdint>

namespace ilp {

/// The ids of life n begin at (n - 1) * numbers_of_a_life + 1 (docs/getting-back-in.md).
inline constexpr std::int64_t numbers_of_a_life = 100'000'000;

}  // namespace ilp
