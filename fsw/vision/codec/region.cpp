#include "fsw/vision/codec/region.hpp"

#include <bit>
#include <cstring>

#include "fsw/vision/codec/wavelet53.hpp"

namespace ilp {
namespace {

// OpenJPEG's coder keeps six fractional bits and a sign in 32.
constexpr int max_coefficient_bits = 25;

// The low band after levels - resolutions + 1 transforms holds the coarsest `resolutions` resolutions.
void mark_coarsest(ImageView<std::uint8_t> mask, int levels, int resolutions) {
  if (resolutions <= 0) return;
  const int level = levels + 1 > resolutions ? levels + 1 - resolutions : 0;
  const std::int32_t width = low_band_side(mask.width, level);
  for (std::int32_t y = 0; y < low_band_side(mask.height, level); ++y) {
    std::memset(mask.row(y), 1, static_cast<std::size_t>(width));
  }
}

struct Magnitudes {
  std::uint32_t region = 0;
  std::uint32_t background = 0;
};

// An OR of magnitudes has as many bits as the largest of them.
Magnitudes measure(ImageView<const std::int32_t> coefficients, ImageView<const std::uint8_t> mask) {
  std::uint32_t region = 0;
  std::uint32_t background = 0;
  for (std::int32_t y = 0; y < coefficients.height; ++y) {
    const std::int32_t* c = coefficients.row(y);
    const std::uint8_t* m = mask.row(y);
    for (std::int32_t x = 0; x < coefficients.width; ++x) {
      const auto magnitude = static_cast<std::uint32_t>(c[x] < 0 ? -c[x] : c[x]);
      const std::uint32_t inside = 0U - m[x];
      region |= magnitude & inside;
      background |= magnitude & ~inside;
    }
  }
  return {region, background};
}

}  // namespace

Status apply_region(ImageView<std::int32_t> samples, ImageView<std::uint8_t> mask, int wavelet_levels,
                    RegionCoding coding, int region_resolutions, std::int32_t* scratch, std::uint8_t* mask_scratch,
                    int& shift) {
  shift = 0;
  if (coding == RegionCoding::none) return {};
  forward_wavelet53(samples, wavelet_levels, scratch);
  propagate_mask53(mask, wavelet_levels, mask_scratch);
  mark_coarsest(mask, wavelet_levels, region_resolutions);
  const Magnitudes magnitudes = measure(samples, mask);
  std::int32_t inside_factor = 1;
  std::int32_t outside_factor = 0;
  if (coding == RegionCoding::shift && magnitudes.background != 0 && magnitudes.region != 0) {
    // One more than the background's bit planes: OpenJPEG's decoder tells region from background by magnitudes that
    // carry one fractional bit.
    shift = static_cast<int>(std::bit_width(magnitudes.background)) + 1;
    const int needed = static_cast<int>(std::bit_width(magnitudes.region)) + shift;
    if (needed > max_coefficient_bits) return {StatusCode::coefficient_overflow, needed, max_coefficient_bits};
    inside_factor = std::int32_t{1} << shift;
  }
  if (coding == RegionCoding::shift) outside_factor = 1;
  for (std::int32_t y = 0; y < samples.height; ++y) {
    std::int32_t* c = samples.row(y);
    const std::uint8_t* m = mask.row(y);
    for (std::int32_t x = 0; x < samples.width; ++x) c[x] *= m[x] != 0 ? inside_factor : outside_factor;
  }
  inverse_wavelet53(samples, wavelet_levels, scratch);
  return {};
}

}  // namespace ilp
