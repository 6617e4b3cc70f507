// Measures the coding error of each quality layer of a product.
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
  int layers = 0;                                                  ///< number of measured layers, from the first one on
  std::array<std::int32_t, limits::max_quality_layers> largest{};  ///< largest |decoded - original| of a sample
  std::array<double, limits::max_quality_layers> mean_square{};
};

/// PSNR that stands for 8-bit samples without any error, dB: above that of one wrong grey value in the largest image.
inline constexpr double exact_psnr_db = 120;

/// Decodes each layer of `file`, a result of encode_jpeg2000 (whole or cut after a layer), and compares it with
/// `samples`, the original. The errors of a layer are those of the file cut after it (truncate_to_layers), over the
/// pixels of `mask` (no data: all pixels; no pixel inside: errors 0). Returns the errors of decode_jpeg2000, or
/// `invalid_argument` if samples or mask have another size.
Status measure_layer_errors(std::span<const std::uint8_t> file, GrayView samples, MaskView mask, LayerErrors& errors);
/// Does the same for samples of up to 16 bits. Layers after the first one whose largest error is at most `enough` are
/// not measured.
Status measure_layer_errors(std::span<const std::uint8_t> file, ImageView<const std::uint16_t> samples, MaskView mask,
                            LayerErrors& errors, std::int32_t enough = -1);

/// Returns the PSNR of 8-bit samples, dB, at most exact_psnr_db.
[[nodiscard]] double psnr_of(double mean_square);

}  // namespace ilp
