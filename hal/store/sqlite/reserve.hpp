// Reserves space on the disk for copying the log into the database: the file NAME-reserve in the database's folder.
#pragma once

#include <cstdint>

#include "fsw/base/status.hpp"

namespace ilp {

/// Makes the reserve of the database, unless it already has at least `bytes`. Returns `store_full` (a = octets) if
/// there is no space for it, `io_error` (a = errno) if it cannot be made on this disk, `capacity_exceeded` if the path
/// is too long.
Status make_reserve(const char* database, std::int64_t bytes);
/// Removes the reserve. Returns false if there was none.
bool release_reserve(const char* database);
/// Size of the reserve; 0 if there is none.
[[nodiscard]] std::int64_t reserved_bytes(const char* database);

}  // namespace ilp
