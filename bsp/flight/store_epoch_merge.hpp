// Merges the records of a flight in memory into its database, which may hold an earlier store epoch.
#pragma once

#include <cstdint>

#include "bsp/flight/memory_copy.hpp"
#include "fsw/base/result.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// Whether the copy can be merged. That is so if the ids of its store epoch begin after all ids of the database, or if
/// the database already has this store epoch, completely or in part. The ids do not follow only if nonvolatile memory
/// and calendar were wrong.
Result<bool> follows(Store& database, MemoryCopy& copy);

/// Merges the copy into the database. The flight then continues with the database where it was in memory
/// (docs/store.md, "Back to the disk"). All writes are in small transactions. After an error or a power cut the same
/// call can be repeated and leads to the same content. `records` becomes the number of records of the copy that were
/// written; `wait` may be null.
Status merge_store_epoch(Store& database, MemoryCopy& copy, DiskWait* wait, std::int64_t& records);

}  // namespace ilp
