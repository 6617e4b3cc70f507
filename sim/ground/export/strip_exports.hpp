// Everything of a strip that other tools open.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/export/georeference.hpp"
#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/intake/result_cache.hpp"
#include "sim/ground/map/ground_grid.hpp"

namespace ilp::exports {

/// A strip with its map, and the files that were written of it.
struct ExportedStrip {
  intake::Strip strip;
  std::string suffix;                   ///< of its files: empty for the first, "-strip-N" for the others
  std::optional<map::GroundGrid> grid;  ///< of the map, whole or, where that is too large, an overview of it
  map::Plane plane;
  Georeference georeference;           ///< where the strip's world is
  std::string place;                   ///< a sentence on where the strip's world is
  std::vector<std::string> files;      ///< that other tools open
  std::vector<std::string> map_files;  ///< those of `files` that follow from the map alone
  std::size_t vertices = 0, faces = 0;
  std::int32_t stride = 1;
};

// Of a strip with a map, `strip.strip`, `strip.suffix`, `strip.grid` and `strip.plane` are given; each function writes
// its files into `folder` and adds their names to `strip.files`. They throw std::runtime_error.

/// Where the strip was flown.
void export_track(const intake::Flight& flight, const Georeference& place, const std::filesystem::path& folder,
                  ExportedStrip& strip);
/// Rasters and surface, which follow from the map alone; `kept` as for write_rasters. Sets `strip.map_files`,
/// `vertices`, `faces` and `stride`.
void export_map(const map::Mosaic& mosaic, const Georeference& place, std::size_t max_vertices,
                const std::filesystem::path& folder, intake::ResultCache* kept, ExportedStrip& strip);
/// The points of the structure, and what ground each image shows.
void export_points_and_footprints(const intake::Flight& flight, const Georeference& place,
                                  const std::filesystem::path& folder, ExportedStrip& strip);

/// The ground that the keyframe's image shows, on the strip's map (footprint.hpp); empty without a map.
[[nodiscard]] std::vector<Vec3> footprint_of(const intake::Keyframe& keyframe, const ExportedStrip& strip);

// Decoded keyframes and merged strips as files that other tools open.

/// KKKKKK-image.png, -mask.png, -depth.png (colours, dark is near) and -depth.pfm (z in strip units, +infinity where
/// there is none), for what the keyframe has. Throws std::runtime_error.
void export_keyframe(std::int64_t id, const intake::KeyframeRasters& rasters, const std::filesystem::path& folder);
/// Whether these files are all there.
[[nodiscard]] bool keyframe_is_exported(const intake::Keyframe& keyframe, const std::filesystem::path& folder);

/// height SUFFIX .pfm (strip units, +infinity where nothing was seen) and sigma SUFFIX .pfm (one sigma of the heights,
/// whole), ortho SUFFIX .png, transparent where nothing was seen, with .pgw (ESRI world file), and count SUFFIX .png
/// (keyframes per cell). Throws std::runtime_error.
void export_grid(const map::GroundGrid& grid, const std::string& suffix, const std::filesystem::path& folder);

}  // namespace ilp::exports
