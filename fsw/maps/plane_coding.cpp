#include "fsw/maps/plane_coding.hpp"

#include <algorithm>
#include <array>
#include <bit>

#include "fsw/base/argument.hpp"
#include "fsw/vision/codec/wavelet53.hpp"
#include "fsw/vision/terrain/bit_coder.hpp"

namespace ilp {
namespace {

using Plane = ImageView<std::int32_t>;

constexpr int plane_levels = 5;
constexpr std::int32_t largest_level = 1 << 21;  // of a coefficient, in steps

enum class Band : std::uint32_t { low, across, diagonal };

/// What an error of 1 in a coefficient does to the plane: Euclidean norms of the synthesis functions, in 1/1024, by
/// level from the finest (as OpenJPEG's dwt.c has them).
constexpr std::int32_t norm_of_low = 21852;  // level 5
constexpr std::array<std::int32_t, plane_levels> norm_across{1063, 1630, 2989, 5840, 11602};
constexpr std::array<std::int32_t, plane_levels> norm_diagonal{736, 944, 1624, 3116, 6163};

/// Of a band's coefficients, in 1/64; 64 is without loss.
std::int32_t step_of(Band band, int level, std::int32_t step) {
  if (step == lossless_step) return finest_plane_step;
  const auto at = static_cast<std::size_t>(level);
  const std::int32_t norm = band == Band::low      ? norm_of_low
                            : band == Band::across ? norm_across[at]
                                                   : norm_diagonal[at];
  return std::max(static_cast<std::int32_t>(std::int64_t{step} * 1024 / norm), finest_plane_step);
}

struct BandPlace {
  Band band;
  int level;  ///< 0: the finest
  std::int32_t x0, y0, x1, y1;
};

/// Calls `use(place)` for every band, from the coarsest to the finest, until it answers no.
template <typename Use>
bool for_each_band(std::int32_t width, std::int32_t height, Use use) {
  if (!use(BandPlace{Band::low, plane_levels - 1, 0, 0, low_band_side(width, plane_levels),
                     low_band_side(height, plane_levels)})) {
    return false;
  }
  for (int level = plane_levels; level-- > 0;) {
    const std::int32_t w = low_band_side(width, level), h = low_band_side(height, level);
    const std::int32_t lw = low_band_side(width, level + 1), lh = low_band_side(height, level + 1);
    if (!use(BandPlace{Band::across, level, lw, 0, w, lh}) || !use(BandPlace{Band::across, level, 0, lh, lw, h}) ||
        !use(BandPlace{Band::diagonal, level, lw, lh, w, h})) {
      return false;
    }
  }
  return true;
}

// A level is coded as its high part in unary digits, an escape in exponential digits, and its low bits.
constexpr std::uint32_t kinds = 3, activities = 28, digits = 14, low_bits = 20;
constexpr std::uint32_t first_low_bit = kinds * activities * digits;
constexpr std::uint32_t first_escape = first_low_bit + kinds * low_bits;
constexpr std::uint32_t first_sign = first_escape + 2 * low_bits;
constexpr std::size_t plane_contexts = first_sign + kinds;

std::int64_t magnitude(std::int32_t value) {
  return value < 0 ? -std::int64_t{value} : std::int64_t{value};
}

struct Context {
  std::uint32_t kind;
  std::uint32_t activity;  ///< how large the neighbours are, two for each power of two
  std::uint32_t shift;     ///< low bits
};

Context context_of(Band band, std::int64_t weighted) {
  // Ten neighbours were added up.
  const auto sum = static_cast<std::uint64_t>(weighted);
  const auto width = static_cast<std::uint32_t>(std::bit_width(sum));
  const std::uint32_t half = width >= 2 ? static_cast<std::uint32_t>(sum >> (width - 2)) & 1U : 0U;
  const std::uint32_t activity = std::min(2 * width + half, activities - 1);
  const auto mean_width = static_cast<std::uint32_t>(std::bit_width(sum / 10));
  return {static_cast<std::uint32_t>(band), activity, std::min(mean_width > 2 ? mean_width - 2 : 0, low_bits - 1)};
}

/// The neighbours that are known when a coefficient is coded, those beside it counted twice, and the coefficient of the
/// next coarser level at the same place.
std::int64_t activity_at(const Plane& plane, const BandPlace& at, std::int32_t x, std::int32_t y) {
  const auto known = [&](std::int32_t u, std::int32_t v) {
    return u >= at.x0 && u < at.x1 && v >= at.y0 ? magnitude(plane.at(u, v)) : 0;
  };
  const std::int64_t beside = known(x - 1, y) + known(x, y - 1);
  const std::int64_t diagonal = known(x - 1, y - 1) + known(x + 1, y - 1);
  const std::int64_t farther = known(x - 2, y) + known(x, y - 2);
  const bool parents = at.band != Band::low && at.level + 1 < plane_levels;
  const std::int64_t parent = parents ? magnitude(plane.at(x / 2, y / 2)) : beside / 2;
  return 2 * beside + diagonal + farther + 2 * parent;
}

class Encoder {
 public:
  explicit Encoder(std::span<std::uint8_t> bytes) : coder_(bytes.data(), bytes.size()) {}

  bool code(const Context& c, std::int32_t& value) {
    const auto level = static_cast<std::uint32_t>(magnitude(value));
    const std::uint32_t high = level >> c.shift;
    const std::uint32_t digit = (c.kind * activities + c.activity) * digits;
    for (std::uint32_t i = 0; i < digits; ++i) {
      coder_.encode(digit + i, i < high ? 1 : 0);
      if (i >= high) break;
    }
    if (high >= digits) escape(high - digits + 1);
    for (std::uint32_t bit = c.shift; bit-- > 0;)
      coder_.encode(first_low_bit + c.kind * low_bits + bit, level >> bit & 1U);
    if (level != 0) coder_.encode(first_sign + c.kind, value < 0 ? 1 : 0);
    return true;
  }
  std::size_t finish() { return coder_.finish(); }

 private:
  void escape(std::uint32_t rest) {
    const auto width = static_cast<std::uint32_t>(std::bit_width(rest));
    for (std::uint32_t i = 1; i < width; ++i) coder_.encode(first_escape + std::min(i, low_bits - 1), 1);
    coder_.encode(first_escape + std::min(width, low_bits - 1), 0);
    for (std::uint32_t bit = width - 1; bit-- > 0;)
      coder_.encode(first_escape + low_bits + std::min(bit, low_bits - 1), rest >> bit & 1U);
  }
  BitEncoder<plane_contexts> coder_;
};

class Decoder {
 public:
  explicit Decoder(std::span<const std::uint8_t> bytes) : coder_(bytes.data(), bytes.size()) {}

  /// False for a level that no encoder writes.
  bool code(const Context& c, std::int32_t& value) {
    std::uint64_t high = 0;
    const std::uint32_t digit = (c.kind * activities + c.activity) * digits;
    // bound: `digits` digits
    while (high < digits && coder_.decode(digit + static_cast<std::uint32_t>(high)) != 0) ++high;
    if (high == digits) {
      std::uint32_t rest = 0;
      if (!escape(rest)) return false;
      high += rest - 1;
    }
    std::uint64_t level = high << c.shift;
    for (std::uint32_t bit = c.shift; bit-- > 0;) {
      level |= std::uint64_t{coder_.decode(first_low_bit + c.kind * low_bits + bit)} << bit;
    }
    if (level > largest_level) return false;
    const bool negative = level != 0 && coder_.decode(first_sign + c.kind) != 0;
    value = negative ? -static_cast<std::int32_t>(level) : static_cast<std::int32_t>(level);
    return true;
  }
  [[nodiscard]] std::size_t used() const { return coder_.used(); }

 private:
  bool escape(std::uint32_t& rest) {
    std::uint32_t width = 1;
    // bound: 22 digits
    while (width <= 22 && coder_.decode(first_escape + std::min(width, low_bits - 1)) != 0) ++width;
    if (width > 22) return false;
    rest = 1;
    for (std::uint32_t bit = width - 1; bit-- > 0;)
      rest = (rest << 1U) | coder_.decode(first_escape + low_bits + std::min(bit, low_bits - 1));
    return true;
  }
  BitDecoder<plane_contexts> coder_;
};

/// Codes all coefficients, in steps; those of the low band by their differences. False as soon as one cannot be.
template <typename Coder>
bool code_levels(Plane levels, Coder& coder) {
  return for_each_band(levels.width, levels.height, [&](const BandPlace& at) {
    for (std::int32_t y = at.y0; y < at.y1; ++y) {
      for (std::int32_t x = at.x0; x < at.x1; ++x) {
        if (!coder.code(context_of(at.band, activity_at(levels, at, x, y)), levels.at(x, y))) return false;
      }
    }
    return true;
  });
}

/// The low band's coefficients become differences to the one on the left, or above.
void take_differences(Plane levels) {
  const std::int32_t w = low_band_side(levels.width, plane_levels), h = low_band_side(levels.height, plane_levels);
  for (std::int32_t y = h; y-- > 0;) {
    for (std::int32_t x = w; x-- > 0;) {
      if (x > 0) {
        levels.at(x, y) -= levels.at(x - 1, y);
      } else if (y > 0) {
        levels.at(x, y) -= levels.at(x, y - 1);
      }
    }
  }
}
bool add_differences(Plane levels) {
  const std::int32_t w = low_band_side(levels.width, plane_levels), h = low_band_side(levels.height, plane_levels);
  for (std::int32_t y = 0; y < h; ++y) {
    for (std::int32_t x = 0; x < w; ++x) {
      if (x > 0) {
        levels.at(x, y) += levels.at(x - 1, y);
      } else if (y > 0) {
        levels.at(x, y) += levels.at(x, y - 1);
      }
      if (magnitude(levels.at(x, y)) > largest_level) return false;
    }
  }
  return true;
}

void quantise(Plane plane, std::int32_t step) {
  static_cast<void>(for_each_band(plane.width, plane.height, [&](const BandPlace& at) {
    const std::int64_t band_step = step_of(at.band, at.level, step);
    for (std::int32_t y = at.y0; y < at.y1; ++y) {
      for (std::int32_t x = at.x0; x < at.x1; ++x) {
        const std::int64_t level = magnitude(plane.at(x, y)) * finest_plane_step / band_step;
        plane.at(x, y) = static_cast<std::int32_t>(plane.at(x, y) < 0 ? -level : level);
      }
    }
    return true;
  }));
}

/// False for a coefficient that no plane has.
bool restore(Plane plane, std::int32_t step) {
  return for_each_band(plane.width, plane.height, [&](const BandPlace& at) {
    const std::int64_t band_step = step_of(at.band, at.level, step);
    // Within a step, small coefficients are more frequent than large ones.
    const std::int64_t inside = band_step == finest_plane_step ? 0 : band_step * 7 / 16;
    for (std::int32_t y = at.y0; y < at.y1; ++y) {
      for (std::int32_t x = at.x0; x < at.x1; ++x) {
        const std::int64_t level = magnitude(plane.at(x, y));
        if (level == 0) continue;
        const std::int64_t value = (level * band_step + inside) / finest_plane_step;
        if (value > largest_level) return false;
        plane.at(x, y) = static_cast<std::int32_t>(plane.at(x, y) < 0 ? -value : value);
      }
    }
    return true;
  });
}

}  // namespace

std::size_t encode_plane(Plane plane, std::int32_t step, std::int32_t* scratch, std::span<std::uint8_t> bytes) {
  forward_wavelet53(plane, plane_levels, scratch);
  quantise(plane, step);
  take_differences(plane);
  Encoder coder(bytes);
  static_cast<void>(code_levels(plane, coder));
  return coder.finish();
}

Status decode_plane(std::span<const std::uint8_t> bytes, std::int32_t step, std::int32_t* scratch, Plane plane) {
  if (!is_plane_step(step)) return out_of_range(Argument::coding_parameters, step);
  Decoder coder(bytes);
  const bool valid = code_levels(plane, coder) && add_differences(plane) && restore(plane, step);
  if (coder.used() > bytes.size()) {
    return {StatusCode::truncated, static_cast<std::int64_t>(bytes.size()), static_cast<std::int64_t>(coder.used())};
  }
  if (!valid || coder.used() < bytes.size()) return {StatusCode::parse_error, static_cast<std::int64_t>(coder.used())};
  inverse_wavelet53(plane, plane_levels, scratch);
  return {};
}

}  // namespace ilp
