// What a run says of the map of a strip, kept in the catalogue: a strip whose map has not changed is not exported
// again.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "sim/ground/export/georeference.hpp"
#include "sim/ground/report/report.hpp"

namespace ilp::ground {

/// Of all that the files of the map depend on; `map` is the digest of the map.
[[nodiscard]] std::uint64_t map_export_digest(std::uint64_t map, const exports::Georeference& place,
                                              const std::string& suffix, std::size_t max_vertices);

/// Geometry, seams, overview, mean plane, and what export_map has set. `parts`: digests of the results from which a
/// changed map is exported in part (write_rasters, measure_seams).
[[nodiscard]] std::vector<std::uint8_t> bytes_of_map(const report::StripResult& strip,
                                                     const std::set<std::uint64_t>& parts);
/// False, with `strip` as it was, where the bytes are not what bytes_of_map gave.
[[nodiscard]] bool take_map(std::span<const std::uint8_t> bytes, report::StripResult& strip,
                            std::set<std::uint64_t>& parts);

}  // namespace ilp::ground
