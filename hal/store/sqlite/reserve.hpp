// Room on the disk that is kept for copying the log into the database: a file NAME-reserve beside it.
#pragma once

#include <cstdint>

#include "fsw/base/status.hpp"

namespace ilp {

/// Makes it, or leaves it as it is. `store_full` (a = octets) if there is no room for it, `io_error` (a = errno) if it
/// cannot be made on this disk.
Status make_reserve(const char* database, std::int64_t bytes);
/// Removes it. False if there was none.
bool release_reserve(const char* database);
/// 0 if there is none.
[[nodiscard]] std::int64_t reserved_bytes(const char* database);

}  // namespace ilp
