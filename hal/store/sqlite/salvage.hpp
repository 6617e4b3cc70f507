// Saves the readable part of a damaged database into a new one.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"
#include "fsw/records/field.hpp"

namespace ilp {

struct SalvageCount {
  std::int64_t saved = 0;
  std::int64_t lost = 0;           ///< records that are known to be lost, or missing ids between two saved records
  std::int64_t damaged_blobs = 0;  ///< in saved records: their damaged chunks stay `record_damaged`
};
using SalvageCounts = std::array<SalvageCount, static_cast<std::size_t>(RecordType::count)>;

/// Copies the readable part of the database at `from` to a new database of at most `limit_bytes` at `to`, where none
/// may exist. Every table is read in the order of ids. If damage stops this, the table is also read from its end, and
/// the ids in between are read one by one, up to max_salvage_probes. Images and depth maps come last: if there is too
/// little space, they are left out and counted as lost. `from` is changed only where it is unreadable: pages of the
/// schema, and checksums of the log, so that SQLite reads the log to its end. `scratch` is for chunks of blobs; its
/// size is a multiple of `blob_chunk_bytes`. The salvage ends with an error after a fault of `to`, or if `from` or its
/// log cannot be read at this time. A record that cannot be read within 2 s counts as lost.
Status salvage(const char* from, const char* to, std::int64_t limit_bytes, std::span<std::uint8_t> scratch,
               SalvageCounts& counts);

inline constexpr std::int64_t max_salvage_probes = 100'000;  ///< per table

}  // namespace ilp
