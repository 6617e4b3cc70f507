// Everything of a strip that other tools open, in one go.
#pragma once

#include <filesystem>

#include "sim/ground/export/georeference.hpp"
#include "sim/ground/report.hpp"

namespace ilp::ground {

/// Into `folder`, with the strip's suffix: rasters, surface, points, track and footprints, in the georeference of
/// `anchors` (may be null). `strip.grid` and `strip.plane` are there. Sets `strip.place`, `strip.vertices`,
/// `strip.faces`, `strip.stride` and `strip.files`. Throws std::runtime_error.
void export_strip(const Report& report, const Mosaic& mosaic, const Anchors* anchors, std::size_t max_vertices,
                  const std::filesystem::path& folder, StripResult& strip);

/// Of a strip without a map: where it was flown. The georeference that it was written in.
Georeference export_track(const Report& report, const Anchors* anchors, const std::filesystem::path& folder,
                          StripResult& strip);

}  // namespace ilp::ground
