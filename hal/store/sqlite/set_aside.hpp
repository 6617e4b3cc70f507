// A database that cannot be used any more makes room for a new one, and is kept.
#pragma once

#include <cstdint>

#include "fsw/base/status.hpp"

namespace ilp {

/// So many are kept; then the latest makes way for the next, and the earlier ones, whose story is the longer, stay.
inline constexpr std::int64_t max_set_aside = 4;

/// Renames the database at `path` and its log to `path.aside-N`; `number` is N, from 1. `io_error` (a = errno) when
/// they cannot be renamed, `capacity_exceeded` for a path that is too long. Nobody may have the database open.
Status set_database_aside(const char* path, std::int64_t& number);

}  // namespace ilp
