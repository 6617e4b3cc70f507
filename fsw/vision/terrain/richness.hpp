// The Image Richness Index: how likely the newly seen part of an image is to show something of interest (paper 4.1,
// which gives no formula; decisions.md, 10). No cue depends on exposure or on the scale of the strip.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/result.hpp"

namespace ilp {

/// Side of a cell, px. Image and depth are averaged over square cells.
inline constexpr std::int32_t richness_cell_px = 4;
inline constexpr std::size_t max_richness_cells = limits::max_image_pixels / richness_cell_px / richness_cell_px;

/// The cues of the newly seen part of an image. g is grey, G its mean in the part; h is the height above the best plane
/// through the part, and D the distance of the camera from that plane. A feature seldom fills the part, so the cues
/// compare its most striking tiles or windows, as high percentiles, with its ordinary ones. Gains, haze and any uniform
/// pattern cancel in these ratios. A window is a square of cells in which a plane is fitted to h; `side` is its side on
/// the ground.
struct RichnessCues {
  double gradient_fine =
      0;  ///< RMS gradient of means of 2x2 px, less noise: ratio of the 97th to the 10th percentile of 16x16 px tiles
  double gradient_coarse = 0;  ///< the same for cell means
  double entropy = 0;          ///< entropy of the histogram of g / G, bits, 0 to 6
  /// |mean of 2x2 px - mean of the 6x6 px around|: ratio of the 99th to the 50th percentile; finds stones; 3.8 for
  /// Gaussian ground.
  double contrast = 0;
  double relief = 0;            ///< 95th minus 5th percentile of h / D
  double slope_steep = 0;       ///< 98th percentile of |grad h| over windows of 9 cells; a tangent
  double slope_excess = 0;      ///< slope_steep minus the median: large for a scarp, small for a hillside
  double roughness_fine = 0;    ///< 98th percentile of RMS (h - plane) / side over windows of 5 cells, less noise
  double roughness_coarse = 0;  ///< the same over windows of 13 cells
  double curvature =
      0;  ///< 98th percentile of |core - rest| / side over windows of 9 cells with a core of 5: bowls, knobs, ledges
  double novelty = 0;        ///< RMS deviation of the scaled cues from the flight's mean, in standard deviations
  double mask_fraction = 0;  ///< number of newly seen pixels divided by that of all pixels
  /// There is enough depth for the terrain cues. If false, they are 0 and count as on plain ground.
  bool has_terrain = false;
};

inline constexpr std::size_t richness_cue_count = 10;  ///< the cues before novelty

/// Scale of a cue: a cue x is scaled to x / (x + half), in [0, 1), and has this weight in the index.
struct CueScale {
  double half = 1;
  double weight = 1;
};

/// Parameters of the index, which express what a mission looks for: `half` is the value at which a cue is strong,
/// `weight` how much it counts. The defaults were fitted to simulated worlds with planted features (docs/products.md,
/// "What is interesting").
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
  double noise_grey = 1.5;             ///< standard deviation of the sensor noise, grey levels
  std::uint32_t novelty_memory = 500;  ///< length of the flight's history, images; older ones fade
};

/// Running mean and variance of the scaled cues over the flight (B. P. Welford, 1962). If the flight has more images
/// than novelty_memory, older ones fade exponentially. Trivially copyable.
struct RichnessHistory {
  std::uint32_t count = 0;  ///< number of images learned
  std::array<double, richness_cue_count> mean{};
  std::array<double, richness_cue_count> variance{};
  /// The halves that scaled the cues; other halves begin a new history.
  std::array<double, richness_cue_count> halves{};
};

struct RichnessWorkspace {
  std::array<float, max_richness_cells> grey, energy;
  /// Position, height above the plane and height error of a cell, in units of the camera's distance from the plane.
  /// They are side by side because sums use all of them.
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
  std::int32_t part;  ///< number of the part that the next slice measures
};

/// Computes the cues of the pixels inside `mask`, and the index in [0, 1]: the weighted mean of the scaled cues. Depth
/// is as in stereo/depth/depth.hpp (sigma 0: no depth). The history is read but not changed: call `learn` when the
/// score is committed, so that a repeated step gives the same score. With too few pixels inside, cues and index are 0.
/// Returns `invalid_argument` if sizes differ or a half or weight is out of range, `image_too_large` if the image
/// exceeds the limits.
Status score_richness(const CameraModel& camera, GrayView image, ImageView<const float> inverse_depth,
                      ImageView<const float> sigma, MaskView mask, const RichnessParams& params,
                      const RichnessHistory& history, RichnessWorkspace& workspace, RichnessCues& cues, double& index);

/// Does the same in slices: call begin_richness once, then score_richness_slice with the same arguments until it
/// returns false.
void begin_richness(RichnessWorkspace& workspace, RichnessCues& cues);
Result<bool> score_richness_slice(const CameraModel& camera, GrayView image, ImageView<const float> inverse_depth,
                                  ImageView<const float> sigma, MaskView mask, const RichnessParams& params,
                                  const RichnessHistory& history, RichnessWorkspace& workspace, RichnessCues& cues,
                                  double& index);

/// Computes novelty and index from measured cues: the last part of score_richness.
[[nodiscard]] double richness_index(const RichnessParams& params, const RichnessHistory& history, RichnessCues& cues);

/// Adds the cues of an image to the history. Images without terrain cues, or without a newly seen part, are left out.
void learn(const RichnessCues& cues, const RichnessParams& params, RichnessHistory& history);

}  // namespace ilp
