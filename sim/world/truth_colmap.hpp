// True poses and points of the ground as a COLMAP text model: what reconstructions are compared with by other tools.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "sim/world/visibility.hpp"

namespace ilp::world {

/// cameras.txt, images.txt and points3D.txt in COLMAP's conventions (pixel centres at 0.5; world-to-camera rotation w x
/// y z and translation); image ids count from 1. Points lie on the ground, spread over what each frame is the first to
/// see; they are listed for every frame that sees them, at their exact projections. std::invalid_argument when there
/// are not as many names as frames or no frames; std::runtime_error when a file cannot be written.
void write_true_colmap_model(std::span<const TrueFrame> frames, const std::vector<std::string>& names,
                             const std::filesystem::path& folder);

}  // namespace ilp::world
