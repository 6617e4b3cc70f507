// Aligns one terrain model to another by their heights: robust least squares on the height differences, as in D.
// Rosenholm and K. Torlegard, "Three-dimensional absolute orientation of stereo models using digital elevation models",
// PE&RS 54(10), 1988. C. Nuth and A. Kaab, The Cryosphere 5, 2011, estimate the shift alone from slope and aspect.
#pragma once

#include <string>
#include <vector>

#include "sim/ground/compare/terrain_samples.hpp"

namespace ilp::compare {

enum class Fit : std::uint8_t { none, shift, similarity };

struct AlignmentParams {
  Fit fit = Fit::shift;
  double max_slope_rad = 0.7853981633974483;  ///< steeper ground is left out: small shifts change its height too much
  std::size_t most_samples = 200000;          ///< 16 MB
};

/// Statistics of height differences, map minus other model, metres.
struct SpreadOfHeights {
  std::size_t cells = 0;
  double mean = 0, median = 0, rmse = 0;
  double nmad = 0;  ///< normalised median absolute deviation
};

struct HeightAlignment {
  host::Similarity3 moved;       ///< transformation of the map in the common frame (model_frames.hpp)
  Vec3 shift = Vec3::Zero();     ///< displacement of the samples' mean position, metres: x, y, up
  Vec3 turn_rad = Vec3::Zero();  ///< rotation vector; only for Fit::similarity
  bool aligned = false;          ///< false: no alignment was wanted, or there are too few samples
  bool horizontal = false;       ///< the relief determines the shift in x and y
  /// Consistency: difference of the further shifts by each half of the samples, split as on a chessboard; metres.
  Vec3 residual = Vec3::Zero();
  SpreadOfHeights before, after;  ///< over the samples of the finest level
  int rounds = 0;                 ///< total number of iterations
  std::vector<std::string> remarks;
};

/// Aligns the map to the other model, from coarse to fine cells. Models with fewer than 100 common samples are not
/// aligned. Afterwards the map is not reduced (HeightModel::reduce), and the other model has cells of about the size of
/// the map's, or its own if they are larger.
[[nodiscard]] HeightAlignment align_heights(HeightModel& map, HeightModel& other, const ModelFrames& frames,
                                            const AlignmentParams& params);

}  // namespace ilp::compare
