#include "fsw/vision/codec/background_fill.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

#include "fsw/base/vector_width.hpp"

namespace ilp {
namespace {

constexpr std::int32_t unknown_sample = std::numeric_limits<std::int32_t>::min();
constexpr int max_levels = 24;

using Level = ImageView<std::int32_t>;

/// The mean of the known ones of four samples; unknown if there are none.
std::int32_t mean_of(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) {
  // Without branches, and with all quotients, because these go in vectors.
  const auto only_if = [](bool condition, std::int32_t value) { return value & -static_cast<std::int32_t>(condition); };
  const auto known = [&](std::int32_t sample) { return only_if(sample != unknown_sample, sample); };
  const auto one = [&](std::int32_t sample) { return only_if(sample != unknown_sample, 1); };
  const std::int32_t sum = known(a) + known(b) + known(c) + known(d);
  const std::int32_t count = one(a) + one(b) + one(c) + one(d);
  return only_if(count == 0, unknown_sample) | only_if(count == 1, sum) | only_if(count == 2, sum / 2) |
         only_if(count == 3, sum / 3) | only_if(count == 4, sum / 4);
}

/// Takes the mean of the known samples in each square of four.
void pull(const Level& fine, const Level& coarse) {
  const std::ptrdiff_t whole = fine.width / 2;
  for (std::int32_t y = 0; y < coarse.height; ++y) {
    const std::int32_t* const upper = fine.row(2 * y);
    const bool paired = 2 * y + 1 < fine.height;
    const std::int32_t* const lower = paired ? fine.row(2 * y + 1) : upper;
    std::int32_t* const __restrict out = coarse.row(y);
    if (paired) {
      for (std::ptrdiff_t x = 0; x < whole; ++x) {
        out[x] = mean_of(upper[2 * x], upper[2 * x + 1], lower[2 * x], lower[2 * x + 1]);
      }
    } else {
      for (std::ptrdiff_t x = 0; x < whole; ++x) {
        out[x] = mean_of(upper[2 * x], upper[2 * x + 1], unknown_sample, unknown_sample);
      }
    }
    if (whole == coarse.width) continue;
    out[whole] = mean_of(upper[2 * whole], paired ? lower[2 * whole] : unknown_sample, unknown_sample, unknown_sample);
  }
}

std::int32_t clamped(std::int32_t i, std::int32_t size) {
  return i < 0 ? 0 : i < size ? i : size - 1;
}

/// Bilinear between the middles of four coarse samples, nearest to the first.
std::int32_t between(std::int32_t nearest, std::int32_t beside, std::int32_t beyond, std::int32_t across) {
  return (9 * nearest + 3 * (beside + beyond) + across + 8) >> 4;
}

/// Interpolates bilinearly from the coarse level, which is known everywhere, to the unknown samples of the fine one.
void push(const Level& coarse, const Level& fine) {
  for (std::int32_t y = 0; y < fine.height; ++y) {
    std::int32_t* const __restrict out = fine.row(y);
    const std::int32_t* const near = coarse.row(y / 2);
    const std::int32_t* const far = coarse.row(clamped(y % 2 == 0 ? y / 2 - 1 : y / 2 + 1, coarse.height));
    const auto fill = [&](std::ptrdiff_t x, std::ptrdiff_t a, std::ptrdiff_t b) {
      const std::int32_t value = between(near[a], near[b], far[a], far[b]);
      out[x] = out[x] == unknown_sample ? value : out[x];
    };
    // Two samples inside of the border at a time: the left and the right half of a coarse one.
    const std::int32_t inner = std::max(fine.width / 2 - 1, 0);
    for (std::ptrdiff_t a = 1; a < inner; ++a) {
      fill(2 * a, a, a - 1);
      fill(2 * a + 1, a, a + 1);
    }
    const auto fill_border = [&](std::int32_t begin, std::int32_t end) {
      for (std::int32_t x = begin; x < end; ++x) {
        fill(x, x / 2, clamped(x % 2 == 0 ? x / 2 - 1 : x / 2 + 1, coarse.width));
      }
    };
    fill_border(0, std::min(2, fine.width));
    fill_border(std::max(2, 2 * inner), fine.width);
  }
}

}  // namespace

void fill_background(ImageView<std::int32_t> samples, MaskView mask, std::int32_t* scratch) {
  std::size_t inside = 0;
  for (std::int32_t y = 0; y < samples.height; ++y) {
    const std::uint8_t* m = mask.row(y);
    for (std::int32_t x = 0; x < samples.width; ++x) inside += m[x] != 0 ? 1U : 0U;
  }
  if (inside == 0 || inside == samples.area()) return;
  for (std::int32_t y = 0; y < samples.height; ++y) {
    const std::uint8_t* m = mask.row(y);
    std::int32_t* row = samples.row(y);
    for (std::int32_t x = 0; x < samples.width; ++x) row[x] = m[x] != 0 ? row[x] : unknown_sample;
  }
  std::array<Level, max_levels> levels;
  std::size_t count = 0;
  levels[count++] = samples;
  std::int32_t* free = scratch;
  while (count < max_levels && (levels[count - 1].width > 1 || levels[count - 1].height > 1)) {
    const Level& fine = levels[count - 1];
    const Level coarse(free, (fine.width + 1) / 2, (fine.height + 1) / 2);
    free += coarse.area();
    with_widest_vectors([&] { pull(fine, coarse); });
    levels[count++] = coarse;
  }
  with_widest_vectors([&] {
    while (--count > 0) push(levels[count], levels[count - 1]);
  });
}

}  // namespace ilp
