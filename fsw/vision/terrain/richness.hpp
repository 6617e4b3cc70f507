// The Image Richness Index: how likely the newly seen part of an image is to show something interesting (paper 4.1,
// which leaves it open; decisions.md, 10). Every cue has a unit that neither exposure nor the strip's scale changes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

/// Image and depth are averaged over cells of this many pixels, a side.
inline constexpr std::int32_t richness_cell_px = 4;
inline constexpr std::size_t max_richness_cells = limits::max_image_pixels / (richness_cell_px * richness_cell_px);

/// All cues on the newly seen part only. g is grey, G its mean there; rms and mean run over pixels or cells whose
/// neighbours lie inside too. h is the height above the best plane through the part and D the camera's distance from
/// that plane; ds is the distance on the plane.
struct RichnessCues {
  double gradient_fine = 0;     ///< rms |grad g| / G, per px, sensor noise taken off
  double gradient_coarse = 0;   ///< rms |grad g| / G, per cell, of cell means
  double entropy = 0;           ///< of the histogram of g / G, bits, 0 to 6
  double contrast = 0;          ///< rms (cell - surroundings) / surroundings; surroundings: mean of 9x9 cells
  double relief = 0;            ///< 95th minus 5th percentile of h / D
  double slope_mean = 0;        ///< mean of |grad h|, a tangent, over a baseline of two cells
  double slope_p90 = 0;         ///< its 90th percentile
  double roughness_fine = 0;    ///< rms (h - mean of the two cells at +-2) / their ds: small blocks, ripples
  double roughness_coarse = 0;  ///< the same at +-6 cells: hummocks
  double curvature = 0;         ///< 95th percentile of |sum of four cells at +-3 - 4 h| / ds: rims, ledges, channels
  double novelty = 0;           ///< rms deviation of the squashed cues from the flight's mean, in standard deviations
  double mask_fraction = 0;     ///< newly seen pixels / all pixels
  bool has_terrain = false;     ///< enough depth for the terrain cues; without it they are 0 and do not count
};

inline constexpr std::size_t richness_cue_count = 10;  ///< those before novelty

/// A cue x counts as x / (x + half), in [0, 1), times its weight.
struct CueScale {
  double half = 1;
  double weight = 1;
};

/// Halves are what ordinary ground shows, so that it scores about one half.
struct RichnessParams {
  CueScale gradient_fine{0.03, 1};
  CueScale gradient_coarse{0.05, 1};
  CueScale entropy{3.5, 0.5};
  CueScale contrast{0.08, 1};
  CueScale relief{0.08, 1.5};
  CueScale slope_mean{0.12, 1};
  CueScale slope_p90{0.3, 1};
  CueScale roughness_fine{0.03, 1};
  CueScale roughness_coarse{0.04, 1};
  CueScale curvature{0.15, 1.5};
  CueScale novelty{1.5, 1};
  double noise_grey = 1.5;         ///< standard deviation of the sensor's noise
  std::uint32_t min_pixels = 256;  ///< a smaller newly seen part has no cues: index 0
};

/// Running mean and variance of the squashed cues over the flight (B. P. Welford, 1962). Trivially copyable.
struct RichnessHistory {
  std::uint32_t count = 0;
  std::array<double, richness_cue_count> mean{};
  std::array<double, richness_cue_count> squares{};  ///< sum of squared deviations
};

struct RichnessWorkspace {
  std::array<float, max_richness_cells> grey, height, x, y, z, buffer;
  std::array<std::uint8_t, max_richness_cells> has_grey, has_depth;
  std::array<double, static_cast<std::size_t>(limits::max_image_width)> ray_x, ray_y;
};

/// Cues of the pixels inside `mask`, and the index in [0, 1]: the weighted mean of the squashed cues. Depth as in
/// stereo/depth.hpp (sigma 0 = none). The history is read, not changed: call `learn` once the score is committed, so
/// that a repeated step scores the same. `invalid_argument`: a = 1 sizes, 2 a half or weight that is not positive.
Status score_richness(const CameraModel& camera, GrayView image, ImageView<const float> inverse_depth,
                      ImageView<const float> sigma, MaskView mask, const RichnessParams& params,
                      const RichnessHistory& history, RichnessWorkspace& workspace, RichnessCues& cues, double& index);

/// Adds an image's cues to what the flight has seen; images without terrain cues or newly seen part are left out.
void learn(const RichnessCues& cues, const RichnessParams& params, RichnessHistory& history);

}  // namespace ilp
