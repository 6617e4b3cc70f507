// Region of interest in the wavelet domain. Converts an image and its mask to coefficients from which an encoder codes
// the region first, or only the region (jpeg2000.hpp).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/codec/jpeg2000.hpp"

namespace ilp {

/// Largest number of low bit planes of the background that may be dropped.
inline constexpr int max_dropped_planes = 6;

/// Estimated size of the coefficients coded without loss, bytes (-10 to +25 % on rendered and recorded images): the
/// entropy of the magnitudes' bit lengths in each band, plus the bits after the first one of each magnitude.
struct CoefficientCosts {
  double region = 0;
  std::array<double, max_dropped_planes + 1> background{};  ///< element q: without the q lowest bit planes
  int region_bits = 0, background_bits = 0;                 ///< bit length of the largest magnitude
};

/// Replaces `samples` (signed, centred on zero) by their wavelet coefficients and `mask` by the mask of the region's
/// coefficients, both in place. If `mask` has no data, everything is region. The `region_resolutions` coarsest
/// resolutions count as region everywhere. `scratch` holds width * height samples.
void to_coefficients(ImageView<std::int32_t> samples, ImageView<std::uint8_t> mask, int wavelet_levels,
                     int region_resolutions, std::int32_t* scratch);

[[nodiscard]] CoefficientCosts measure_costs(ImageView<const std::int32_t> coefficients,
                                             ImageView<const std::uint8_t> mask, int wavelet_levels);

struct RegionShift {
  int shift = 0;           ///< shift that the header declares, bit planes; 0: no region marker
  int dropped_planes = 0;  ///< number of lowest bit planes that are not coded
};

/// Chooses the shift for a background without its lowest `dropped_planes` bit planes; 0 if there is no background.
/// Returns `coefficient_overflow` if a scaled coefficient would need more than 25 bits.
Status choose_shift(const CoefficientCosts& costs, int dropped_planes, RegionShift& shift);

/// Scales the coefficients for coding, in place. Those of the region are multiplied by 2^(shift - dropped_planes);
/// those of the background are divided by 2^dropped_planes, or set to 0 if `coding` drops the background.
void scale_region(ImageView<std::int32_t> coefficients, ImageView<const std::uint8_t> mask, RegionCoding coding,
                  const RegionShift& shift);

}  // namespace ilp
