// Gives SQLite its memory from one fixed arena (architecture, "Memory").
#pragma once

#include "fsw/base/arena.hpp"
#include "fsw/base/heap_gate.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

/// Call it once per process, before the first store is opened. The arena must outlive every store. Without this call
/// SQLite uses the system heap (host tools). Returns `store_error` if SQLite is already running.
Status configure_sqlite_memory(Arena& arena);

/// The number of this arena in an `arena_exhausted`; it follows those of the regions in fsw/base/heap_gate.hpp.
inline constexpr std::int64_t sqlite_arena_number = static_cast<std::int64_t>(HeapRegion::count);
/// Size of the latest request that the arena refused, bytes.
[[nodiscard]] std::int64_t refused_sqlite_bytes();

}  // namespace ilp
