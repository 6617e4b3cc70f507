// What a run says of the map of a strip, kept in the catalogue: a strip whose map has not changed is not exported
// again.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sim/ground/export/georeference.hpp"
#include "sim/ground/report/report.hpp"

namespace ilp::ground {

/// Of all that the files of the map depend on; `map` is the digest of the map.
[[nodiscard]] std::uint64_t map_export_digest(std::uint64_t map, const exports::Georeference& place,
                                              const std::string& suffix, std::size_t max_vertices);

/// Geometry, seams, overview, mean plane, and what export_map has set.
[[nodiscard]] std::vector<std::uint8_t> bytes_of_map(const report::StripResult& strip);
/// False, with `strip` as it was, where the bytes are not what bytes_of_map gave.
[[nodiscard]] bool take_map(std::span<const std::uint8_t> bytes, report::StripResult& strip);

}  // namespace ilp::ground
