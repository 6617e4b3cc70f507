// Renames a database that cannot be used any more, to make room for a new one.
#pragma once

#include <cstdint>

#include "fsw/base/status.hpp"

namespace ilp {

/// At most this many are kept. After that the latest is replaced, and the earlier ones, which hold more of the flight,
/// stay.
inline constexpr std::int64_t max_quarantined = 4;

/// Renames the database at `path` and its log to `path.aside-N`; `number` is N, from 1. `io_error` (a = errno) when
/// they cannot be renamed, `capacity_exceeded` for a path that is too long. No process may have the database open.
Status quarantine_database(const char* path, std::int64_t& number);

}  // namespace ilp
