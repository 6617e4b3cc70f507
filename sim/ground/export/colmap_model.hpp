// Poses and points of a strip as a COLMAP text model: cameras.txt, images.txt, points3D.txt, in COLMAP's conventions
// (pixel centres at 0.5; world-to-camera rotation w x y z and translation).
#pragma once

#include <filesystem>

#include "sim/ground/intake/flight_model.hpp"

namespace ilp::exports {

struct ColmapCounts {
  std::size_t images = 0, points = 0, observations = 0;
};

/// Keyframes with final poses; image ids are keyframe ids. Observations in keyframes without a pose are left out, and
/// points seen fewer than twice after that. Throws std::runtime_error when the folder cannot be written.
ColmapCounts write_colmap_model(const intake::Flight& flight, const intake::Strip& strip,
                                const std::filesystem::path& folder);

}  // namespace ilp::exports
