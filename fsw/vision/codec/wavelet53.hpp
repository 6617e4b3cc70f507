// The reversible 5/3 wavelet transform of JPEG 2000 (ITU-T T.800, annex F), integer to integer, without loss. Decoders
// have the inverse.
#pragma once

#include <cstdint>

#include "fsw/base/image_view.hpp"

namespace ilp {

/// Transforms in place, `levels` times: columns, then rows, of the top-left rectangle that the previous level left.
/// Afterwards the low band of the last level is at (0,0) with ceil(size / 2^levels) samples per side, and each level's
/// HL, LH and HH bands are right of, below and diagonal to the rectangle of its low band. Symmetric extension at the
/// borders; any size. `scratch` holds width * height samples. Exact when every intermediate sum fits 32 bits: |x| <
/// 2^25 is safe.
void forward_wavelet53(ImageView<std::int32_t> image, int levels, std::int32_t* scratch);

/// The inverse, in place. Exact where the coefficients are those of a transform; it is safe for any others below 2^22.
void inverse_wavelet53(ImageView<std::int32_t> image, int levels, std::int32_t* scratch);

/// Converts the mask of pixels to the mask of coefficients in the layout above, in place: a coefficient is 1 when a
/// pixel inside (not 0) needs it for its reconstruction, else 0. The pixels inside then do not depend on the
/// coefficients outside. `scratch` holds width * height bytes.
void propagate_mask53(ImageView<std::uint8_t> mask, int levels, std::uint8_t* scratch);

/// Side of the low band after `level` transforms: ceil(side / 2^level).
[[nodiscard]] constexpr std::int32_t low_band_side(std::int32_t side, int level) {
  return (side + (std::int32_t{1} << level) - 1) >> level;
}

}  // namespace ilp
