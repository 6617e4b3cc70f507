// How well the ground in each cell of an image was seen: one byte, so that a keyframe far back in the flight can say
// whether it has seen a place at least as well as a later one does.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/terrain/depth_coding.hpp"

namespace ilp {

/// A quality is 0 where no ground is known. Otherwise it combines two quantities:
/// - the sampling, the size of a pixel on the ground (distance / focal length), in sixths of an octave. Levels repeat
///   after 63 sixths, so that no unit of length is preferred; a comparison is right for ratios below 32.
/// - the estimated sigma of the distance relative to the distance, in four classes: up to 0.25 %, 0.5 %, 1 %, and more.
inline constexpr std::int32_t sampling_levels = 63;
inline constexpr std::int32_t sampling_levels_per_octave = 6;

/// `sampling` and `relative_sigma` above 0; 0 for any other value.
[[nodiscard]] std::uint8_t seen_quality(double sampling, double relative_sigma);

/// The difference in sampling that is nearest to a ratio of at least 1.
[[nodiscard]] std::int32_t sampling_steps(double ratio);

/// Whether ground that was seen with quality `seen` is known at least as well as a view with quality `now` would show
/// it. The new view is better only if its sampling is finer by `finer_steps` or more and the error of the distance, in
/// units of length, is smaller. Unknown ground (`seen` = 0) is never known well; a view without ground (`now` = 0) is
/// never better.
[[nodiscard]] bool at_least_as_well(std::uint8_t seen, std::uint8_t now, std::int32_t finer_steps);

/// The same where the ratio of both samplings is known from the geometry: the new view is finer by `finer`, and better
/// only if that is `claim_ratio` or more and the error of the distance is smaller. An error that is not known (`now` =
/// 0) counts as smaller. The qualities may be in different units of length.
[[nodiscard]] bool at_least_as_well(std::uint8_t seen, std::uint8_t now, double finer, double claim_ratio);

inline constexpr std::int32_t seen_cell_px = 8;
[[nodiscard]] constexpr std::int32_t seen_cells_side(std::int32_t side_px) {
  return (side_px + seen_cell_px - 1) / seen_cell_px;
}
inline constexpr std::size_t max_seen_cells = static_cast<std::size_t>(seen_cells_side(limits::max_image_width)) *
                                              static_cast<std::size_t>(seen_cells_side(limits::max_image_height));

/// Qualities of square cells of an image, row by row from its top left corner. Trivially copyable.
struct SeenCells {
  std::int32_t columns = 0, rows = 0;
  std::array<std::uint8_t, max_seen_cells> quality{};

  /// Of the cell with pixel (x, y), which the caller keeps inside the image.
  [[nodiscard]] std::uint8_t at(std::int32_t x, std::int32_t y) const { return quality[index(x, y)]; }
  [[nodiscard]] std::uint8_t& of(std::int32_t x, std::int32_t y) { return quality[index(x, y)]; }

 private:
  [[nodiscard]] std::size_t index(std::int32_t x, std::int32_t y) const {
    return static_cast<std::size_t>(y / seen_cell_px) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(x / seen_cell_px);
  }
};

/// Cells without ground. `image_too_large`.
Status clear_seen_cells(std::int32_t width, std::int32_t height, SeenCells& cells);

/// The maps of a depth record as the store has them: inverse depth = offset + step * code, 0 outside the mask; errors
/// as codes of sigma_map.hpp for all pixels that were matched.
struct StoredDepth {
  ImageView<const std::uint16_t> codes;
  ImageView<const std::uint8_t> sigma_codes;
  DepthCoding coding;
  double disparity_per_inverse_depth_px = 0;
};

/// The quality of cells in which at least `min_pixels` pixels have depth: the sampling of their mean inverse depth, and
/// their mean sigma. A cell whose pixels were matched but have no stored depth takes the mean depth of the keyframe.
/// `invalid_argument`: sizes, focal length, scale of disparity or coding; `image_too_large`.
Status seen_cells(const StoredDepth& depth, double focal_px, std::int32_t min_pixels, SeenCells& cells);

/// The same from inverse depth and its sigma; pixels with sigma <= 0 have no depth.
Status seen_cells(ImageView<const float> inverse_depth, ImageView<const float> sigma, double focal_px,
                  std::int32_t min_pixels, SeenCells& cells);

}  // namespace ilp
