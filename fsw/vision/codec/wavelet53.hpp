// The reversible 5/3 wavelet transform of JPEG 2000 (ITU-T T.800, annex F), integer to integer, without loss. Every
// decoder has its inverse.
#pragma once

#include <cstdint>

#include "fsw/base/image_view.hpp"

namespace ilp {

/// Transforms the image in place, `levels` times. Each level transforms columns, then rows, of the low band of the
/// previous level, the rectangle at the top left. Afterwards the low band of the last level is at (0,0) with ceil(size
/// / 2^levels) samples per side; the HL, LH and HH bands of each level lie right of, below and diagonal to the low band
/// of that level. Borders are extended symmetrically; any size is allowed. `scratch` holds width * height samples. The
/// result is exact if every intermediate sum fits 32 bits, as for |x| < 2^25.
void forward_wavelet53(ImageView<std::int32_t> image, int levels, std::int32_t* scratch);

/// Inverts the transform in place. The result is exact for coefficients of forward_wavelet53; no other coefficients
/// below 2^22 overflow. `scratch` as above.
void inverse_wavelet53(ImageView<std::int32_t> image, int levels, std::int32_t* scratch);

/// Converts a mask of pixels to the mask of coefficients in the layout above, in place: a coefficient is 1 if the
/// reconstruction of a pixel inside (not 0) needs it, else 0. The pixels inside then do not depend on coefficients
/// outside the mask. `scratch` holds width * height bytes.
void propagate_mask53(ImageView<std::uint8_t> mask, int levels, std::uint8_t* scratch);

/// Returns the side of the low band after `level` transforms: ceil(side / 2^level).
[[nodiscard]] constexpr std::int32_t low_band_side(std::int32_t side, int level) {
  return (side + (std::int32_t{1} << level) - 1) >> level;
}

}  // namespace ilp
