// Writes the truth of a simulated flight that follows from poses and depths, in the formats in which the ground exports
// its products.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "sim/world/camera_state.hpp"
#include "sim/world/height_grid.hpp"
#include "sim/world/visibility.hpp"

namespace ilp::world {

// True poses and ground points as a COLMAP text model, with which other tools compare reconstructions.

/// Writes cameras.txt, images.txt and points3D.txt in COLMAP's conventions: pixel centres at 0.5, world-to-camera
/// rotation (w x y z) and translation. Image ids begin at 1. The points lie on the ground and are distributed over the
/// area that each frame is the first to see. A point is listed for every frame that sees it, at its exact projection.
/// Throws std::invalid_argument without frames or for a number of names other than that of frames, and
/// std::runtime_error if a file cannot be written.
void write_true_colmap_model(std::span<const TrueFrame> frames, const std::vector<std::string>& names,
                             const std::filesystem::path& folder);

struct TruthSource {
  CameraModel camera;
  std::vector<CameraState> states;  ///< one per frame
  std::vector<std::string> names;   ///< of the images, one per frame; STEM below is a name without extension
  HeightsAlongRow heights;          ///< of the ground, m; may be empty
};

/// Reads DIR/depth/STEM.pfm of every frame (z-depth in m of every pixel of the image as taken) and writes into DIR:
///   overlap.csv              frame_a,frame_b,overlap,footprint: for all ordered pairs with more than 5 %, the share of
///                            a's area whose ground b sees too (true_overlap), and true_footprint_overlap
///   visible-before/STEM.png  255 where an earlier frame has seen the ground of the pixel
///   height.pfm, .pgw, .tif   true heights (height_grid.hpp), where `heights` are given
///   colmap/                  true poses and points of the ground
/// The same inputs give the same bytes for any number of threads (0: one per core). Memory holds the sampled depth maps
/// of all frames (sample_stride, at most 1 MB each) and one complete depth map per thread. Throws std::invalid_argument
/// unless there is one name per state, and std::runtime_error if a file cannot be read or written.
void write_truth(const std::filesystem::path& dir, const TruthSource& source, std::size_t threads = 0);

}  // namespace ilp::world
