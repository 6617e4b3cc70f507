// Exports strips and keyframes as files for other tools.
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
  std::string suffix;                   ///< suffix of file names: empty for the first strip, "-strip-N" for the others
  std::optional<map::GroundGrid> grid;  ///< the map, or an overview if it is too large; none: no map
  map::Plane plane;                     ///< mean plane of the grid
  Georeference georeference;
  std::string place;                    ///< a sentence that describes the georeference
  std::vector<std::string> files;       ///< names of the exported files
  std::vector<std::string> map_files;   ///< those of `files` that depend on the map alone
  std::size_t vertices = 0, faces = 0;  ///< of the surface model
  std::int32_t stride = 1;              ///< cells of the grid per vertex of the surface model (grid_surface.hpp)
};

// The export_ functions of a strip write their files into `folder` and add the names to `strip.files`. The caller has
// set `strip.strip` and `strip.suffix`, and `strip.grid` and `strip.plane` if there is a map. They throw
// std::runtime_error.

/// Exports the track of the camera (track_export.hpp).
void export_track(const intake::Flight& flight, const Georeference& place, const std::filesystem::path& folder,
                  ExportedStrip& strip);
/// Exports rasters and surface models, which depend on the map alone. Sets `strip.map_files`, `vertices`, `faces` and
/// `stride`. `max_vertices`: of a surface model. `kept`: as in write_rasters.
void export_map(const map::Mosaic& mosaic, const Georeference& place, std::size_t max_vertices,
                const std::filesystem::path& folder, intake::ResultCache* kept, ExportedStrip& strip);
/// Exports the points of the structure, and the footprints of the images.
void export_points_and_footprints(const intake::Flight& flight, const Georeference& place,
                                  const std::filesystem::path& folder, ExportedStrip& strip);

/// The ground that the keyframe's image shows, on the strip's map (footprint.hpp); empty without a map.
[[nodiscard]] std::vector<Vec3> footprint_of(const intake::Keyframe& keyframe, const ExportedStrip& strip);

/// Writes KKKKKK-image.png, -mask.png, -depth.png (colour-coded, dark is near) and -depth.pfm (camera z in strip units;
/// +infinity: no depth), as far as the keyframe has these rasters. Throws std::runtime_error.
void export_keyframe(std::int64_t id, const intake::KeyframeRasters& rasters, const std::filesystem::path& folder);
/// Whether all files that export_keyframe would write are there.
[[nodiscard]] bool keyframe_is_exported(const intake::Keyframe& keyframe, const std::filesystem::path& folder);

/// Writes height SUFFIX .pfm (strip units; +infinity: no height), sigma SUFFIX .pfm (standard deviation with all
/// components), ortho SUFFIX .png (transparent where nothing was seen) with .pgw (ESRI world file), and count SUFFIX
/// .png (keyframes per cell). Throws std::runtime_error.
void export_grid(const map::GroundGrid& grid, const std::string& suffix, const std::filesystem::path& folder);

}  // namespace ilp::exports
