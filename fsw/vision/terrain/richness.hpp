// The Image Richness Index: how likely the newly seen part of an image is to show something interesting (paper 4.1,
// which leaves it open; decisions.md, 10). No cue depends on exposure or on the strip's scale.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/result.hpp"

namespace ilp {

/// Image and depth are averaged over square cells with sides of this many pixels.
inline constexpr std::int32_t richness_cell_px = 4;
inline constexpr std::size_t max_richness_cells = limits::max_image_pixels / richness_cell_px / richness_cell_px;

/// The cues of the newly seen part of an image. g is grey, G its mean there; h is the height above the best plane
/// through the part and D the camera's distance from that plane. A feature seldom fills the part. So the cues compare
/// its most striking places, as high percentiles over tiles and windows, with its ordinary ones. Gains, haze and any
/// pattern that is the same everywhere cancel in those ratios. Windows are squares of cells in which a plane is fitted
/// to h; side is the window's on the ground.
struct RichnessCues {
  double gradient_fine =
      0;  ///< rms gradient of means of 2x2 px, 97th over 10th percentile of tiles of 16x16 px, less noise
  double gradient_coarse = 0;  ///< the same of cell means
  double entropy = 0;          ///< of the histogram of g / G, bits, 0 to 6
  double contrast = 0;         ///< |2x2 px - 6x6 px around|, 99th over 50th percentile: stones; 3.8 for Gaussian ground
  double relief = 0;           ///< 95th minus 5th percentile of h / D
  double slope_steep = 0;      ///< 98th percentile of |grad h| over windows of 9 cells, a tangent
  double slope_excess = 0;     ///< the same minus the median: it is large for a scarp, not for a hillside
  double roughness_fine = 0;   ///< 98th percentile of rms (h - plane) / side over windows of 5 cells, without noise
  double roughness_coarse = 0;  ///< the same of 13 cells
  double curvature =
      0;  ///< 98th percentile of |core - rest| / side over windows of 9 cells, core 5: bowls, knobs, ledges
  double novelty = 0;        ///< rms deviation of the squashed cues from the flight's mean, in standard deviations
  double mask_fraction = 0;  ///< newly seen pixels / all pixels
  bool has_terrain = false;  ///< enough depth for the terrain cues; without it they are 0 and count as on plain ground
};

inline constexpr std::size_t richness_cue_count = 10;  ///< those before novelty

/// A cue x counts as x / (x + half), in [0, 1), times its weight.
struct CueScale {
  double half = 1;
  double weight = 1;
};

/// What a mission looks for: a half says when a cue is strong, a weight how much it counts. The defaults
/// were fitted to simulated worlds with planted features (docs/products.md, "What is interesting").
struct RichnessParams {
  CueScale gradient_fine{1.7, 2.7};
  CueScale gradient_coarse{2.1, 2.2};
  CueScale entropy{2.4, 0.3};
  CueScale contrast{3.7, 1.6};
  CueScale relief{0.013, 0.38};
  CueScale slope_steep{0.1, 0.3};
  CueScale slope_excess{0.066, 0.3};
  CueScale roughness_fine{0.03, 0.38};
  CueScale roughness_coarse{0.02, 1.2};
  CueScale curvature{0.026, 0.87};
  CueScale novelty{1, 0.3};
  double noise_grey = 1.5;             ///< standard deviation of the sensor's noise
  std::uint32_t novelty_memory = 500;  ///< images: older ones fade from the flight's history
};

/// Running mean and variance of the squashed cues over the flight (B. P. Welford, 1962). When the flight has more
/// images than the memory holds, older ones fade exponentially. Trivially copyable.
struct RichnessHistory {
  std::uint32_t count = 0;  ///< images learned
  std::array<double, richness_cue_count> mean{};
  std::array<double, richness_cue_count> variance{};
  std::array<double, richness_cue_count> halves{};  ///< that squashed the cues; other halves begin a new history
};

struct RichnessWorkspace {
  std::array<float, max_richness_cells> grey, energy;
  /// A cell on the plane, all in units of the camera's distance from it; side by side, because sums take all of them.
  struct Raised {
    float x, y, height, sigma;
  };
  std::array<Raised, max_richness_cells> raised;
  std::array<std::uint8_t, max_richness_cells> has_grey, has_energy, has_depth;
  /// Sums over squares of 2x2 px.
  std::array<std::uint16_t, 4 * max_richness_cells> half_sum;
  std::array<std::uint8_t, 4 * max_richness_cells> half_count;
  std::array<float, 4 * max_richness_cells> buffer;
  std::array<double, static_cast<std::size_t>(limits::max_image_width)> ray_x, ray_y;
  std::int32_t part;  ///< what the next slice measures
};

/// Computes the cues of the pixels inside `mask`, and the index in [0, 1]: the weighted mean of the squashed cues.
/// Depth as in stereo/depth.hpp (sigma 0 = none). The history is read, not changed: call `learn` once the score is
/// committed, so that a repeated step gives the same score. `invalid_argument`: sizes, a half or weight out of
/// its range.
Status score_richness(const CameraModel& camera, GrayView image, ImageView<const float> inverse_depth,
                      ImageView<const float> sigma, MaskView mask, const RichnessParams& params,
                      const RichnessHistory& history, RichnessWorkspace& workspace, RichnessCues& cues, double& index);

/// The same in slices: one call of begin_richness, then of score_richness_slice with the same arguments while there
/// is more.
void begin_richness(RichnessWorkspace& workspace, RichnessCues& cues);
Result<bool> score_richness_slice(const CameraModel& camera, GrayView image, ImageView<const float> inverse_depth,
                                  ImageView<const float> sigma, MaskView mask, const RichnessParams& params,
                                  const RichnessHistory& history, RichnessWorkspace& workspace, RichnessCues& cues,
                                  double& index);

/// The second half of `score_richness`: novelty and index of cues that were measured before.
[[nodiscard]] double richness_index(const RichnessParams& params, const RichnessHistory& history, RichnessCues& cues);

/// Adds an image's cues to the history. Images without terrain cues or without a newly seen part are left out.
void learn(const RichnessCues& cues, const RichnessParams& params, RichnessHistory& history);

}  // namespace ilp
