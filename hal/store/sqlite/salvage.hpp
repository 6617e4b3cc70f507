// What can be read of a damaged database is saved into a new one.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"
#include "fsw/records/field.hpp"

namespace ilp {

struct SalvageCount {
  std::int64_t saved = 0;
  std::int64_t lost = 0;           ///< known of, or presumed between two that were saved
  std::int64_t damaged_blobs = 0;  ///< of saved records: their damaged chunks stay `record_damaged`
};
using SalvageCounts = std::array<SalvageCount, static_cast<std::size_t>(RecordType::count)>;

/// Makes a database at `to`, where none may be, of at most `limit_bytes`. Every table is walked by id; where damage
/// stops the walk also from its end, and the ids in between are asked for one by one, so many of them at most. Images
/// and depth maps come last: where there is too little room they are what is left out, and counted as lost. In the
/// damaged database only what is unreadable is written to: pages of the schema, and checksums of the log, so that
/// SQLite reads it to its end. `scratch`: for pieces of blobs, of a multiple of `blob_chunk_bytes`. A fault of `to`
/// ends it.
Status salvage(const char* from, const char* to, std::int64_t limit_bytes, std::span<std::uint8_t> scratch,
               SalvageCounts& counts);

inline constexpr std::int64_t max_salvage_probes = 100'000;  ///< of a table

}  // namespace ilp
