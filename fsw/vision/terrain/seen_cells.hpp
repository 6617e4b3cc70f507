// Quality with which the ground in each cell of an image was seen. It takes one byte, so that keyframes far back in the
// flight can be compared with later ones of the same ground.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/terrain/depth_coding.hpp"

namespace ilp {

/// A quality is 0 if no ground is known. Otherwise it combines two quantities:
/// - the sampling: the size of a pixel on the ground (distance / focal length), in levels of a sixth of an octave.
///   Levels repeat after 63, so that no unit of length is preferred; a comparison is right for ratios below 32.
/// - the estimated sigma of the distance divided by the distance, in four classes: up to 0.25 %, 0.5 %, 1 %, and more.
inline constexpr std::int32_t sampling_levels = 63;
inline constexpr std::int32_t sampling_levels_per_octave = 6;

/// Returns the quality for a `sampling` and a `relative_sigma` above 0; 0 if either is another value.
[[nodiscard]] std::uint8_t seen_quality(double sampling, double relative_sigma);

/// Returns the number of sampling levels nearest to a ratio; at least 1. `ratio` is at least 1.
[[nodiscard]] std::int32_t sampling_steps(double ratio);

/// Returns true if ground seen with quality `seen` is known at least as well as a view of quality `now` would show it.
/// The view is better only if two conditions hold: its sampling is finer by `finer_steps` levels or more, and its
/// distance error in units of length is smaller. Unknown ground (`seen` = 0) is never known well; a view without ground
/// (`now` = 0) is never better.
[[nodiscard]] bool at_least_as_well(std::uint8_t seen, std::uint8_t now, std::int32_t finer_steps);

/// Does the same if the ratio of the samplings is known from the geometry: `finer` is the sampling of the old view
/// divided by that of the new one. The new view is better only if `finer` is at least `claim_ratio` and its distance
/// error is smaller. An unknown error (`now` = 0) counts as smaller. The qualities may be in different units of length.
[[nodiscard]] bool at_least_as_well(std::uint8_t seen, std::uint8_t now, double finer, double claim_ratio);

inline constexpr std::int32_t seen_cell_px = 8;
[[nodiscard]] constexpr std::int32_t seen_cells_side(std::int32_t side_px) {
  return (side_px + seen_cell_px - 1) / seen_cell_px;
}
inline constexpr std::size_t max_seen_cells = static_cast<std::size_t>(seen_cells_side(limits::max_image_width)) *
                                              static_cast<std::size_t>(seen_cells_side(limits::max_image_height));

/// Qualities of the square cells of an image, row by row from the top left. Trivially copyable.
struct SeenCells {
  std::int32_t columns = 0, rows = 0;
  std::array<std::uint8_t, max_seen_cells> quality{};

  /// Return the quality of the cell that contains pixel (x, y). The caller ensures that the pixel is inside the image.
  [[nodiscard]] std::uint8_t at(std::int32_t x, std::int32_t y) const { return quality[index(x, y)]; }
  [[nodiscard]] std::uint8_t& of(std::int32_t x, std::int32_t y) { return quality[index(x, y)]; }

 private:
  [[nodiscard]] std::size_t index(std::int32_t x, std::int32_t y) const {
    return static_cast<std::size_t>(y / seen_cell_px) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(x / seen_cell_px);
  }
};

/// Sets the size and clears all cells. Returns `image_too_large` if the size is out of range.
Status clear_seen_cells(std::int32_t width, std::int32_t height, SeenCells& cells);

/// The maps of a depth record as the store has them. Inverse depth = offset + step * code; the code is 0 outside the
/// mask. `sigma_codes` are the codes of sigma_map.hpp for all matched pixels.
struct StoredDepth {
  ImageView<const std::uint16_t> codes;
  ImageView<const std::uint8_t> sigma_codes;
  DepthCoding coding;
  double disparity_per_inverse_depth_px = 0;
};

/// Computes the quality of each cell with at least `min_pixels` matched pixels, from their mean inverse depth and their
/// mean sigma. If none of its matched pixels has a stored depth, the cell takes the mean inverse depth of the keyframe.
/// Returns `invalid_argument` if sizes differ, or if focal length, scale of disparity or coding is not valid;
/// `image_too_large` if the size is out of range.
Status seen_cells(const StoredDepth& depth, double focal_px, std::int32_t min_pixels, SeenCells& cells);

/// Does the same from inverse depth and its sigma; pixels with sigma <= 0 have no depth.
Status seen_cells(ImageView<const float> inverse_depth, ImageView<const float> sigma, double focal_px,
                  std::int32_t min_pixels, SeenCells& cells);

}  // namespace ilp
