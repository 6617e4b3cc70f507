// Measures the error of each quality layer of a product.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/codec/jpeg2000.hpp"

namespace ilp {

struct LayerErrors {
  int layers = 0;                                                  ///< that were measured, from the first one on
  std::array<std::int32_t, limits::max_quality_layers> largest{};  ///< |decoded - original|, of one sample
  std::array<double, limits::max_quality_layers> mean_square{};
};

/// PSNR of 8-bit samples that are all exact: above that of one wrong grey value in the largest image.
inline constexpr double exact_psnr_db = 120;

/// `file` is a result of encode_jpeg2000, cut after a layer or not, and `samples` is what was coded. Each layer is
/// decoded. The errors are those of the file cut after it (truncate_to_layers), over the pixels of `mask` (empty: all;
/// no pixel: no error). Errors of decode_jpeg2000; `invalid_argument` for samples or a mask of another size.
Status measure_layer_errors(std::span<const std::uint8_t> file, GrayView samples, MaskView mask, LayerErrors& errors);
///
/// Layers after the first one whose largest error is at most `enough` are not measured.
Status measure_layer_errors(std::span<const std::uint8_t> file, ImageView<const std::uint16_t> samples, MaskView mask,
                            LayerErrors& errors, std::int32_t enough = -1);

/// PSNR of 8-bit samples, dB.
[[nodiscard]] double psnr_of(double mean_square);

}  // namespace ilp
