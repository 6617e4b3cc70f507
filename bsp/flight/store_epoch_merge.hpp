// Takes the records of a flight in memory into its database, which may have an earlier store epoch.
#pragma once

#include <cstdint>

#include "bsp/flight/memory_copy.hpp"
#include "fsw/base/result.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// Whether the ids of the copied store epoch begin after all ids of the database, as they do unless the nonvolatile
/// memory and the calendar were wrong, or whether the database has this store epoch already, in part or whole.
Result<bool> follows(Store& database, MemoryCopy& copy);

/// Afterwards the flight goes on from the database where it was in memory (docs/store.md, "Back to the disk"). All
/// writes are in small transactions; if one fails, or power is cut, the same call begins again and ends the same.
/// `records` counts those of the copy.
Status merge_store_epoch(Store& database, MemoryCopy& copy, DiskWait* wait, std::int64_t& records);

}  // namespace ilp
