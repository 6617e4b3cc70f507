// Region of interest by its wavelet coefficients: makes of an image and its mask the coefficients of which an encoder
// codes the region first, or only the region (see jpeg2000.hpp).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/codec/jpeg2000.hpp"

namespace ilp {

/// Low bit planes of the background that may be dropped.
inline constexpr int max_dropped_planes = 6;

/// Estimated bytes of the coefficients without loss (-10 to +25 % on rendered and recorded images): the entropy of the
/// magnitudes' bit lengths in each band, plus the bits after each magnitude's first one.
struct CoefficientCosts {
  double region = 0;
  std::array<double, max_dropped_planes + 1> background{};  ///< without its q lowest planes
  int region_bits = 0, background_bits = 0;                 ///< bit length of the largest magnitude
};

/// Replaces `samples` (signed, about zero) by their coefficients and `mask` (may be empty: everything) by the region's
/// mask of coefficients, both in place. `scratch` holds width * height samples.
void to_coefficients(ImageView<std::int32_t> samples, ImageView<std::uint8_t> mask, int wavelet_levels,
                     int region_resolutions, std::int32_t* scratch);

[[nodiscard]] CoefficientCosts measure_costs(ImageView<const std::int32_t> coefficients,
                                             ImageView<const std::uint8_t> mask, int wavelet_levels);

struct RegionShift {
  int shift = 0;           ///< shift that the header declares; 0: no region marker
  int dropped_planes = 0;  ///< lowest planes of everything that are not coded
};

/// The shift for the background without its lowest `dropped_planes`, 0 if there is no background;
/// `coefficient_overflow` when a scaled coefficient would need more than 25 bits.
Status choose_shift(const CoefficientCosts& costs, int dropped_planes, RegionShift& shift);

/// Scales the coefficients as they are coded, in place: the region's times 2^(shift - dropped_planes), the background's
/// divided by 2^dropped_planes, or zero.
void scale_region(ImageView<std::int32_t> coefficients, ImageView<const std::uint8_t> mask, RegionCoding coding,
                  const RegionShift& shift);

}  // namespace ilp
