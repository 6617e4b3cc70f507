// Writes poses and points of a strip as a COLMAP text model: cameras.txt, images.txt, points3D.txt, in COLMAP's
// conventions (pixel centres at 0.5; world-to-camera quaternion w x y z and translation).
#pragma once

#include <filesystem>

#include "sim/ground/intake/flight_model.hpp"

namespace ilp::exports {

struct ColmapCounts {
  std::size_t images = 0, points = 0, observations = 0;
};

/// Writes the keyframes with final poses, and the points with at least two observations in them. Image ids are keyframe
/// ids. Throws std::runtime_error if the folder cannot be written.
ColmapCounts write_colmap_model(const intake::Flight& flight, const intake::Strip& strip,
                                const std::filesystem::path& folder);

}  // namespace ilp::exports
