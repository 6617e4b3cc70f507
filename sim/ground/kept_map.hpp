// Serialises what a run reports about the map of a strip. The catalogue keeps these bytes, so that a later run does not
// export an unchanged map again.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "sim/ground/export/georeference.hpp"
#include "sim/ground/report/report.hpp"

namespace ilp::ground {

/// Digest of everything that the exported files of a map depend on; `map` is the digest of the map itself.
[[nodiscard]] std::uint64_t map_export_digest(std::uint64_t map, const exports::Georeference& place,
                                              const std::string& suffix, std::size_t max_vertices);

/// Serialises geometry, seams, overview and mean plane of the strip's map, and what export_map has set. `parts`:
/// digests of the results for parts of the map, which an export of a changed map uses again (write_rasters,
/// measure_seams).
[[nodiscard]] std::vector<std::uint8_t> bytes_of_map(const report::StripResult& strip,
                                                     const std::set<std::uint64_t>& parts);
/// Reads back what bytes_of_map wrote. Returns false and leaves `strip` unchanged if the bytes are damaged.
[[nodiscard]] bool take_map(std::span<const std::uint8_t> bytes, report::StripResult& strip,
                            std::set<std::uint64_t>& parts);

}  // namespace ilp::ground
