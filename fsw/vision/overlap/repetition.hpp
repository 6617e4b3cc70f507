// Measures whether an image repeats itself. Ripples, furrows and pavements match themselves one period away, so that
// none of their matches is reliable (decisions.md, 2).
#pragma once

#include <array>

#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

inline constexpr std::int32_t repetition_max_side = 256;   ///< px; larger images are refused
inline constexpr std::int32_t repetition_reach_px = 8;     ///< px; largest shift that is tried on large images
inline constexpr std::int32_t repetition_small_side = 64;  ///< px; up to this side all shifts with a fifth in common

struct RepetitionWorkspace {
  static constexpr std::int32_t rows = repetition_small_side, columns = 2 * repetition_small_side + 1;
  std::array<std::int16_t, static_cast<std::size_t>(repetition_max_side) * repetition_max_side> detail;
  std::array<std::int32_t, static_cast<std::size_t>(repetition_max_side + 1) * (repetition_max_side + 1)> sums;
  std::array<std::int64_t, static_cast<std::size_t>(repetition_max_side + 1) * (repetition_max_side + 1)> energy;
  std::array<double, static_cast<std::size_t>(rows) * columns> correlation;
};

/// Writes the highest peak of the image's autocorrelation other than at shift 0 to `peak`; 0 if there is none. The
/// correlation at each shift is normalised over the part that overlaps. The mean over 8 x 8 pixels is removed first, so
/// that shading does not count. Returns `image_too_large` if a side is above repetition_max_side.
Status measure_repetition(GrayView image, RepetitionWorkspace& workspace, double& peak);

}  // namespace ilp
