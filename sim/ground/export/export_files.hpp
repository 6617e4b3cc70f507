// Decoded keyframes and merged strips as files that other tools open.
#pragma once

#include <filesystem>
#include <string>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/map/ground_grid.hpp"

namespace ilp::exports {

/// KKKKKK-image.png, -mask.png, -depth.png (colours, dark is near) and -depth.pfm (z in strip units, +infinity where
/// there is none), for what the keyframe has. Throws std::runtime_error.
void export_keyframe(std::int64_t id, const intake::KeyframeRasters& rasters, const std::filesystem::path& folder);
/// Whether these files are all there.
[[nodiscard]] bool keyframe_is_exported(const intake::Keyframe& keyframe, const std::filesystem::path& folder);

/// height SUFFIX .pfm (strip units, +infinity where nothing was seen) and sigma SUFFIX .pfm (of the heights), ortho
/// SUFFIX .png with .pgw (ESRI world file), and count SUFFIX .png (keyframes per cell). Throws std::runtime_error.
void export_grid(const map::GroundGrid& grid, const std::string& suffix, const std::filesystem::path& folder);

}  // namespace ilp::exports
