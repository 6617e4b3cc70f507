// Where a strip was flown and what its images show, as GeoJSON.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "fsw/vision/geometry/types.hpp"
#include "sim/ground/export/georeference.hpp"

namespace ilp::exports {

/// track SUFFIX .geojson: the way of the camera as a line, then a point for every posed keyframe with its attributes
/// (keyframe_columns). Nothing for a strip without poses: false. Throws std::runtime_error.
bool write_track(const intake::Flight& flight, const intake::Strip& strip, const Georeference& place,
                 const std::string& suffix, const std::filesystem::path& folder);

/// footprints SUFFIX .geojson: a polygon with the same attributes for every keyframe that has an outline (footprint);
/// false when none has. Throws std::runtime_error.
bool write_footprints(const intake::Flight& flight, const intake::Strip& strip,
                      const std::map<std::int64_t, std::vector<Vec3>>& outlines, const Georeference& place,
                      const std::string& suffix, const std::filesystem::path& folder);

}  // namespace ilp::exports
