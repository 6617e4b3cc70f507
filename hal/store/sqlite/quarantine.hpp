// Renames a database that can no longer be used, so that a new one can replace it.
#pragma once

#include <cstdint>

#include "fsw/base/status.hpp"

namespace ilp {

/// Largest number of quarantined databases. After that the latest is replaced; the earlier ones stay, because they hold
/// more of the flight.
inline constexpr std::int64_t max_quarantined = 4;

/// Renames the database at `path` and its log to `path.aside-N`; `number` is N, from 1. No process may have the
/// database open. Returns `io_error` (a = errno) if they cannot be renamed, `capacity_exceeded` if the path is too
/// long.
Status quarantine_database(const char* path, std::int64_t& number);

}  // namespace ilp
