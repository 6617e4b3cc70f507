#include "fsw/vision/codec/region.hpp"

#include <bit>
#include <cstring>

#include "fsw/base/math.hpp"
#include "fsw/base/vector_width.hpp"
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

constexpr std::size_t max_bit_length = 32;

/// Histogram of the coefficients of a band by the bit lengths of their magnitudes.
struct BitLengths {
  std::array<std::uint32_t, max_bit_length + 1> counts{};

  [[nodiscard]] double bytes(int dropped_planes) const {
    std::array<std::uint32_t, max_bit_length + 1> left{};
    std::uint32_t all = 0;
    for (std::size_t length = 0; length < counts.size(); ++length) {
      const auto dropped = static_cast<std::size_t>(dropped_planes);
      left[length > dropped ? length - dropped : 0] += counts[length];
      all += counts[length];
    }
    double bits = 0;
    for (std::size_t length = 0; length < left.size(); ++length) {
      if (left[length] == 0) continue;
      const auto count = static_cast<double>(left[length]);
      // The sign takes the place of the first bit, which the length implies.
      bits += count * (det_log(all / count) / ln2 + static_cast<double>(length));
    }
    return bits / 8;
  }

  static constexpr double ln2 = 0.69314718055994530942;
};

struct Rectangle {
  std::int32_t x0, y0, x1, y1;
};

void count_band(ImageView<const std::int32_t> coefficients, ImageView<const std::uint8_t> mask, const Rectangle& band,
                CoefficientCosts& costs) {
  std::array<BitLengths, 2> lengths{};  // background, region
  std::array<std::uint32_t, 2> magnitudes{};
  for (std::int32_t y = band.y0; y < band.y1; ++y) {
    const std::int32_t* c = coefficients.row(y);
    const std::uint8_t* m = mask.data != nullptr ? mask.row(y) : nullptr;
    for (std::int32_t x = band.x0; x < band.x1; ++x) {
      const auto magnitude = static_cast<std::uint32_t>(c[x] < 0 ? -c[x] : c[x]);
      const std::size_t part = m != nullptr ? m[x] : 1U;
      magnitudes[part] |= magnitude;
      ++lengths[part].counts[static_cast<std::size_t>(std::bit_width(magnitude))];
    }
  }
  // An OR of magnitudes has as many bits as the largest of them.
  costs.background_magnitude |= magnitudes[0];
  costs.region_magnitude |= magnitudes[1];
  costs.region += lengths[1].bytes(0);
  for (int q = 0; q <= max_dropped_planes; ++q) costs.background[static_cast<std::size_t>(q)] += lengths[0].bytes(q);
}

/// Multiplies the region's coefficients, and leaves the lowest planes of the others out, or all of them.
void scale_row(const std::uint8_t* mask, std::int32_t width, std::int32_t factor, bool drop, int planes,
               std::int32_t* __restrict c) {
  const std::int32_t below = (std::int32_t{1} << planes) - 1;
  const std::int32_t kept = drop ? 0 : ~std::int32_t{0};
  for (std::int32_t x = 0; x < width; ++x) {
    // Rounds towards zero, as a division does.
    const std::int32_t outside = ((c[x] + ((c[x] >> 31) & below)) >> planes) & kept;
    const std::int32_t inside = c[x] * factor;
    c[x] = mask[x] != 0 ? inside : outside;
  }
}

}  // namespace

void to_coefficients(ImageView<std::int32_t> samples, ImageView<std::uint8_t> mask, int wavelet_levels,
                     int region_resolutions, std::int32_t* scratch) {
  forward_wavelet53(samples, wavelet_levels, scratch);
  if (mask.data == nullptr) return;
  propagate_mask53(mask, wavelet_levels, reinterpret_cast<std::uint8_t*>(scratch));
  mark_coarsest(mask, wavelet_levels, region_resolutions);
}

CoefficientCosts measure_costs(ImageView<const std::int32_t> coefficients, ImageView<const std::uint8_t> mask,
                               int wavelet_levels) {
  CoefficientCosts costs;
  std::int32_t width = low_band_side(coefficients.width, wavelet_levels);
  std::int32_t height = low_band_side(coefficients.height, wavelet_levels);
  count_band(coefficients, mask, {0, 0, width, height}, costs);
  for (int level = wavelet_levels - 1; level >= 0; --level) {
    const std::int32_t whole_width = low_band_side(coefficients.width, level);
    const std::int32_t whole_height = low_band_side(coefficients.height, level);
    count_band(coefficients, mask, {width, 0, whole_width, height}, costs);
    count_band(coefficients, mask, {0, height, width, whole_height}, costs);
    count_band(coefficients, mask, {width, height, whole_width, whole_height}, costs);
    width = whole_width;
    height = whole_height;
  }
  return costs;
}

Status choose_shift(const CoefficientCosts& costs, int dropped_planes, RegionShift& shift) {
  shift = {};
  if (costs.background_magnitude == 0 || costs.region_magnitude == 0) return {};
  // One more than the background's bit planes: OpenJPEG's decoder tells region from background by magnitudes that
  // carry one fractional bit.
  shift.shift = static_cast<int>(std::bit_width(costs.background_magnitude)) + 1;
  shift.dropped_planes = dropped_planes < shift.shift ? dropped_planes : shift.shift - 1;
  const int needed = static_cast<int>(std::bit_width(costs.region_magnitude)) + shift.shift - shift.dropped_planes;
  if (needed > max_coefficient_bits) return {StatusCode::coefficient_overflow, needed, max_coefficient_bits};
  return {};
}

void scale_region(ImageView<std::int32_t> coefficients, ImageView<const std::uint8_t> mask, RegionCoding coding,
                  const RegionShift& shift) {
  const bool drop = coding == RegionCoding::drop_background;
  if (mask.data == nullptr || (!drop && shift.shift == 0)) return;
  const std::int32_t factor = std::int32_t{1} << (shift.shift - shift.dropped_planes);
  const int planes = drop ? 0 : shift.dropped_planes;
  with_widest_vectors([&] {
    for (std::int32_t y = 0; y < coefficients.height; ++y) {
      scale_row(mask.row(y), coefficients.width, factor, drop, planes, coefficients.row(y));
    }
  });
}

}  // namespace ilp
