// Lays one terrain model onto another by their heights alone: robust least squares on the height differences, as D.
// Rosenholm and K. Torlegard, "Three-dimensional absolute orientation of stereo models using digital elevation models",
// PE&RS 54(10), 1988. The shift alone is what C. Nuth and A. Kaab, The Cryosphere 5, 2011, estimate by slope and
// aspect.
#pragma once

#include <string>
#include <vector>

#include "sim/ground/compare/terrain_samples.hpp"

namespace ilp::compare {

enum class Fit : std::uint8_t { none, shift, similarity };

struct AlignmentParams {
  Fit fit = Fit::shift;
  double max_slope_rad = 0.7853981633974483;  ///< steeper ground is left out: a small shift changes its height by much
  std::size_t most_samples = 200000;          ///< 16 MB
};

/// Of height differences, map minus other model, metres.
struct SpreadOfHeights {
  std::size_t cells = 0;
  double mean = 0, median = 0, rmse = 0;
  double nmad = 0;  ///< 1.4826 times the median distance from the median
};

struct HeightAlignment {
  host::Similarity3 moved;       ///< common frame: where the map was put
  Vec3 shift = Vec3::Zero();     ///< of the middle of the common ground, metres: x, y, up
  Vec3 turn_rad = Vec3::Zero();  ///< about x, y, z; only for Fit::similarity
  bool aligned = false;
  bool horizontal = false;        ///< whether x and y could be determined
  Vec3 residual = Vec3::Zero();   ///< difference of the shifts that the two halves of a chessboard would still ask for
  SpreadOfHeights before, after;  ///< over the samples of the alignment
  int rounds = 0;
  std::vector<std::string> remarks;
};

/// Reduces both models as it needs, and leaves them reduced so that their cells have about one size, that of the
/// coarser model at most. Fewer than 100 common samples are not aligned.
[[nodiscard]] HeightAlignment align_heights(HeightModel& map, HeightModel& other, const ModelFrames& frames,
                                            const AlignmentParams& params);

}  // namespace ilp::compare
