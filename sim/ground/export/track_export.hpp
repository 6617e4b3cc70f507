// Writes the track of a strip and the footprints of its images as GeoJSON.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "fsw/vision/geometry/types.hpp"
#include "sim/ground/export/georeference.hpp"

namespace ilp::exports {

/// Writes track SUFFIX .geojson: the track of the camera as a line, then a point for every keyframe with a final pose,
/// with its attributes (keyframe_columns). Returns false, without a file, if the strip has no poses. Throws
/// std::runtime_error.
bool write_track(const intake::Flight& flight, const intake::Strip& strip, const Georeference& place,
                 const std::string& suffix, const std::filesystem::path& folder);

/// Writes footprints SUFFIX .geojson: a polygon with the same attributes for every keyframe with an outline.
/// `outlines`: footprints (footprint.hpp); key: keyframe id. Returns false, without a file, if there is none. Throws
/// std::runtime_error.
bool write_footprints(const intake::Flight& flight, const intake::Strip& strip,
                      const std::map<std::int64_t, std::vector<Vec3>>& outlines, const Georeference& place,
                      const std::string& suffix, const std::filesystem::path& folder);

}  // namespace ilp::exports
