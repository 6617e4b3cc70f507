// SQLite's memory comes from one fixed arena (architecture, "Memory").
#pragma once

#include "fsw/base/arena.hpp"
#include "fsw/base/heap_gate.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

/// Call it once per process, before the first store is opened. The arena outlives every store. Without this call SQLite
/// uses the system heap (host tools). `store_error` when SQLite is already running.
Status configure_sqlite_memory(Arena& arena);

/// The number of this arena in an `arena_exhausted`, after the regions of fsw/base/heap_gate.hpp; and the latest
/// request that it refused, in bytes.
inline constexpr std::int64_t sqlite_arena_number = static_cast<std::int64_t>(HeapRegion::count);
[[nodiscard]] std::int64_t refused_sqlite_bytes();

}  // namespace ilp
