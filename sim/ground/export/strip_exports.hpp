// Everything of a strip that other tools open.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/export/georeference.hpp"
#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/map/ground_grid.hpp"

namespace ilp::exports {

/// A strip with its map, and the files that were written of it.
struct ExportedStrip {
  intake::Strip strip;
  std::string suffix;                   ///< of its files: empty for the first, "-strip-N" for the others
  std::optional<map::GroundGrid> grid;  ///< of the map, whole or, where that is too large, an overview of it
  map::Plane plane;
  std::string place;               ///< a sentence on where the strip's world is
  std::vector<std::string> files;  ///< that other tools open
  std::size_t vertices = 0, faces = 0;
  std::int32_t stride = 1;
};

/// Writes rasters, surface, points, track and footprints into `folder`, in the georeference of `anchors` (may be null).
/// `strip.strip`, `strip.suffix`, `strip.grid` and `strip.plane` are given, the rest of `strip` is set. Throws
/// std::runtime_error.
void export_strip(const intake::Flight& flight, const map::Mosaic& mosaic, const Anchors* anchors,
                  std::size_t max_vertices, const std::filesystem::path& folder, ExportedStrip& strip);

/// Writes where a strip without a map was flown, and returns the georeference of the file.
Georeference export_track(const intake::Flight& flight, const Anchors* anchors, const std::filesystem::path& folder,
                          ExportedStrip& strip);

/// The ground that the keyframe's image shows, on the strip's map (footprint.hpp); empty without a map.
[[nodiscard]] std::vector<Vec3> footprint_of(const intake::Keyframe& keyframe, const ExportedStrip& strip);

// Decoded keyframes and merged strips as files that other tools open.

/// KKKKKK-image.png, -mask.png, -depth.png (colours, dark is near) and -depth.pfm (z in strip units, +infinity where
/// there is none), for what the keyframe has. Throws std::runtime_error.
void export_keyframe(std::int64_t id, const intake::KeyframeRasters& rasters, const std::filesystem::path& folder);
/// Whether these files are all there.
[[nodiscard]] bool keyframe_is_exported(const intake::Keyframe& keyframe, const std::filesystem::path& folder);

/// height SUFFIX .pfm (strip units, +infinity where nothing was seen) and sigma SUFFIX .pfm (of the heights), ortho
/// SUFFIX .png with .pgw (ESRI world file), and count SUFFIX .png (keyframes per cell). Throws std::runtime_error.
void export_grid(const map::GroundGrid& grid, const std::string& suffix, const std::filesystem::path& folder);

}  // namespace ilp::exports
