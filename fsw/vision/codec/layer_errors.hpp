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
  int decodings = 0;       ///< layers that had to be decoded
  int decoded_blocks = 0;  ///< code-blocks of the other layers that had to be decoded
};

/// PSNR of 8-bit samples that are all exact: above that of one wrong grey value in the largest image.
inline constexpr double exact_psnr_db = 120;

/// `file` is the latest result of encode_jpeg2000 in this workspace, or that result cut after a layer, and `samples` is
/// what was coded. The errors are those of the file cut after each layer (truncate_to_layers), over the pixels of
/// `mask` (empty: all; no pixel: no error). Every decoder gives these samples. They are computed from the coefficients
/// that were coded and the coding passes that each layer has (layer_decoder.hpp), in the rectangle around the mask. A
/// code-block is decoded where its last pass in a layer lacks a byte. A file whose packets or bit planes do not fit the
/// workspace's coefficients is decoded, layer by layer; the workspace's `samples` are then overwritten. Errors of
/// decode_jpeg2000; `invalid_argument` for samples or a mask of another size.
Status measure_layer_errors(std::span<const std::uint8_t> file, GrayView samples, MaskView mask,
                            Jpeg2000Workspace& workspace, LayerErrors& errors);
///
/// Layers after the first one whose largest error is at most `enough` are not measured.
Status measure_layer_errors(std::span<const std::uint8_t> file, ImageView<const std::uint16_t> samples, MaskView mask,
                            Jpeg2000Workspace& workspace, LayerErrors& errors, std::int32_t enough = -1);

/// PSNR of 8-bit samples, dB.
[[nodiscard]] double psnr_of(double mean_square);

}  // namespace ilp
