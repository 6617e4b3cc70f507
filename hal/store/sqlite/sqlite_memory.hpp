// SQLite's memory comes from one fixed arena (architecture, "Memory").
#pragma once

#include "fsw/base/arena.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

/// Once per process, before the first store is opened. The arena outlives every store. Without this call SQLite uses
/// the system heap (host tools). `store_error` when SQLite is already running.
Status configure_sqlite_memory(Arena& arena);

}  // namespace ilp
