// The truth of a simulated flight beyond poses and depths, in the formats in which the ground exports its products.
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

// True poses and points of the ground as a COLMAP text model: what reconstructions are compared with by other tools.

/// cameras.txt, images.txt and points3D.txt in COLMAP's conventions (pixel centres at 0.5; world-to-camera rotation w x
/// y z and translation); image ids count from 1. Points lie on the ground, spread over what each frame is the first to
/// see; they are listed for every frame that sees them, at their exact projections. std::invalid_argument when there
/// are not as many names as frames or no frames; std::runtime_error when a file cannot be written.
void write_true_colmap_model(std::span<const TrueFrame> frames, const std::vector<std::string>& names,
                             const std::filesystem::path& folder);

struct TruthSource {
  CameraModel camera;
  std::vector<CameraState> states;  ///< one per frame
  std::vector<std::string> names;   ///< of the images, one per frame; depths are NAME's stem .pfm
  HeightsAlongRow heights;          ///< of the ground, m; may be empty
};

/// Reads DIR/depth/STEM.pfm of every frame (z-depth, m, of every pixel of the image as taken) and writes into DIR:
///   overlap.csv              frame_a,frame_b,overlap,footprint: for all ordered pairs with more than 5 %, the share of
///                            a's ground that b sees too (true_overlap), and the same of footprints alone
///   visible-before/STEM.png  255 where an earlier frame has seen the ground of the pixel
///   height.pfm, .pgw, .tif   true heights (height_grid.hpp), where `heights` are given
///   colmap/                  true poses and points of the ground
/// The same inputs give the same bytes for any number of threads (0: one per core). Of the depth maps, one sample in a
/// block is held for all frames (1 MB a frame at most, sample_stride), the whole of one per thread.
/// std::invalid_argument for other than one name per state, std::runtime_error for a file that cannot be read or
/// written.
void write_truth(const std::filesystem::path& dir, const TruthSource& source, std::size_t threads = 0);

}  // namespace ilp::world
