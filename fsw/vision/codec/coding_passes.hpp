// What a decoder makes of the first coding passes of a code-block, from the coefficients that were coded (ITU-T T.800,
// annex D): no bit is decoded, because the passes only say which planes of which coefficients are known.
#pragma once

#include <cstdint>

#include "fsw/base/image_view.hpp"

namespace ilp {

struct KnownPasses {
  int passes = 0;   ///< from the first one on; at most 3 * planes - 2
  int planes = 0;   ///< bit planes of the largest magnitude
  int dropped = 0;  ///< bit planes below the coefficients that are not coded; planes + dropped <= 30
  int shift = 0;    ///< of the region (Maxshift), in bit planes from the lowest dropped one
};

/// `block` has at most 64 by 64 coefficients. `decoded` gets those from (x, y) of the block on, as many as it has:
/// known planes, half of the last known plane, the shift undone, rounded to whole numbers towards zero (OpenJPEG's
/// reconstruction for the reversible transform).
void decode_passes(ImageView<const std::int32_t> block, const KnownPasses& known, std::int32_t x, std::int32_t y,
                   ImageView<std::int32_t> decoded);

}  // namespace ilp
