// The ranges of record ids in the store epochs of a flight. A store epoch is the content of one database.
#pragma once

#include <cstdint>

namespace ilp {

/// The ids of store epoch n begin at (n - 1) * ids_per_store_epoch + 1 (docs/getting-back-in.md).
inline constexpr std::int64_t ids_per_store_epoch = 100'000'000;

}  // namespace ilp
