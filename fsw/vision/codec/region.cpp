#include "fsw/vision/codec/region.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

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

constexpr int max_bit_length = 32;

/// Histogram of the coefficients of a band by the bit lengths of their magnitudes.
struct BitLengths {
  std::array<std::uint32_t, std::size_t{max_bit_length} + 1> counts{};

  [[nodiscard]] double bytes(int dropped_planes) const {
    std::array<std::uint32_t, std::size_t{max_bit_length} + 1> left{};
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

  [[nodiscard]] int longest() const {
    int length = max_bit_length;
    while (length > 0 && counts[static_cast<std::size_t>(length)] == 0) --length;
    return length;
  }

  static constexpr double ln2 = 0.69314718055994530942;
};

struct Rectangle {
  std::int32_t x0, y0, x1, y1;
};

// The background's bytes are this much above those of the region.
constexpr std::uint8_t of_background = 32;

/// The bit lengths of magnitudes below 2^24, which are the exponents that floating point has for them.
void classify_row(const std::int32_t* __restrict c, const std::uint8_t* __restrict mask, std::ptrdiff_t width,
                  std::uint8_t* __restrict classes) {
  constexpr std::int32_t exponent_of_half = 126, mantissa_bits = 23;
  const auto length = [&](std::ptrdiff_t x) {
    const std::int32_t magnitude = c[x] < 0 ? -c[x] : c[x];
    const std::int32_t exponent = std::bit_cast<std::int32_t>(static_cast<float>(magnitude)) >> mantissa_bits;
    return exponent > exponent_of_half ? exponent - exponent_of_half : 0;
  };
  if (mask == nullptr) {
    for (std::ptrdiff_t x = 0; x < width; ++x) classes[x] = static_cast<std::uint8_t>(length(x));
  } else {
    for (std::ptrdiff_t x = 0; x < width; ++x) {
      classes[x] = static_cast<std::uint8_t>(length(x) | (mask[x] != 0 ? 0 : of_background));
    }
  }
}

/// Counts bytes below 64, with a counter of its own for each of 32 neighbours.
class ByteCounts {
 public:
  void add_row(const std::uint8_t* bytes, std::ptrdiff_t count) {
    const std::ptrdiff_t groups = count / lanes;
    if (added_ + groups > std::numeric_limits<std::uint8_t>::max()) finish();
    added_ += groups;
    std::uint8_t longest = 0, parts = 0;
    for (std::ptrdiff_t i = 0; i < groups * lanes; ++i) {
      const auto length = static_cast<std::uint8_t>(bytes[i] % of_background);
      longest = length > longest ? length : longest;
      parts |= bytes[i] >= of_background ? std::uint8_t{2} : std::uint8_t{1};
    }
    if ((parts & 1U) != 0) count_values(bytes, groups, 0, longest);
    if ((parts & 2U) != 0) count_values(bytes, groups, of_background, longest);
    for (std::ptrdiff_t i = groups * lanes; i < count; ++i) ++sums_[bytes[i] % values];
  }
  void finish() {
    for (std::size_t value = 0; value < values; ++value) {
      for (const std::uint8_t counter : counters_[value]) sums_[value] += counter;
      counters_[value] = {};
    }
    added_ = 0;
  }
  [[nodiscard]] std::uint32_t of(std::size_t value) const { return sums_[value]; }

 private:
  static constexpr std::ptrdiff_t lanes = 32;
  static constexpr std::size_t values = 64;
  static_assert(limits::max_image_side / lanes <= std::numeric_limits<std::uint8_t>::max());

  void count_values(const std::uint8_t* bytes, std::ptrdiff_t groups, std::uint8_t first, std::uint8_t longest) {
    for (std::size_t length = 0; length <= longest; ++length) {
      const auto value = static_cast<std::uint8_t>(first + length);
      auto counters = counters_[value];
      for (std::ptrdiff_t group = 0; group < groups; ++group) {
        const std::uint8_t* const part = bytes + group * lanes;
        for (std::size_t i = 0; i < counters.size(); ++i) {
          counters[i] = static_cast<std::uint8_t>(counters[i] + (part[i] == value ? 1 : 0));
        }
      }
      counters_[value] = counters;
    }
  }

  std::array<std::array<std::uint8_t, lanes>, values> counters_{};
  std::array<std::uint32_t, values> sums_{};
  std::ptrdiff_t added_ = 0;
};

void count_band(ImageView<const std::int32_t> coefficients, ImageView<const std::uint8_t> mask, const Rectangle& band,
                CoefficientCosts& costs) {
  ByteCounts counts;
  const std::ptrdiff_t width = band.x1 - band.x0;
  with_widest_vectors([&] {
    std::array<std::uint8_t, static_cast<std::size_t>(limits::max_image_side)> classes;
    for (std::int32_t y = band.y0; y < band.y1; ++y) {
      const std::uint8_t* const m = mask.data != nullptr ? mask.row(y) + band.x0 : nullptr;
      classify_row(coefficients.row(y) + band.x0, m, width, classes.data());
      counts.add_row(classes.data(), width);
    }
    counts.finish();
  });
  BitLengths region, background;
  for (std::size_t length = 0; length < of_background; ++length) {
    region.counts[length] = counts.of(length);
    background.counts[length] = counts.of(of_background + length);
  }
  costs.region_bits = std::max(costs.region_bits, region.longest());
  costs.background_bits = std::max(costs.background_bits, background.longest());
  costs.region += region.bytes(0);
  for (int q = 0; q <= max_dropped_planes; ++q) costs.background[static_cast<std::size_t>(q)] += background.bytes(q);
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
  if (costs.background_bits == 0 || costs.region_bits == 0) return {};
  // One more than the background's bit planes: OpenJPEG's decoder tells region from background by magnitudes that
  // carry one fractional bit.
  shift.shift = costs.background_bits + 1;
  shift.dropped_planes = dropped_planes < shift.shift ? dropped_planes : shift.shift - 1;
  const int needed = costs.region_bits + shift.shift - shift.dropped_planes;
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
