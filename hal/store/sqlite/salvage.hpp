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
  std::int64_t lost = 0;           ///< records known to be lost, or presumed between two saved ones
  std::int64_t damaged_blobs = 0;  ///< in saved records: their damaged chunks stay `record_damaged`
};
using SalvageCounts = std::array<SalvageCount, static_cast<std::size_t>(RecordType::count)>;

/// Makes a database of at most `limit_bytes` at `to`, where none may exist. Every table is walked by id. If damage
/// stops the walk, the table is also walked from its end, and the ids in between are read one by one, up to
/// max_salvage_probes. Images and depth maps come last: if there is too little room they are left out and counted as
/// lost. The damaged database is written to only where it is unreadable: pages of the schema, and checksums of the log,
/// so that SQLite reads it to its end. `scratch` is for pieces of blobs and has a multiple of `blob_chunk_bytes`. A
/// fault of `to` ends the salvage, and so does a database that cannot be opened or whose log cannot be read at this
/// time. A record that cannot be read although it is tried for 2 s counts as lost.
Status salvage(const char* from, const char* to, std::int64_t limit_bytes, std::span<std::uint8_t> scratch,
               SalvageCounts& counts);

inline constexpr std::int64_t max_salvage_probes = 100'000;  ///< per table

}  // namespace ilp
