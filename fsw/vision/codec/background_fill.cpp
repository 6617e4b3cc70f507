#include "fsw/vision/codec/background_fill.hpp"

#include <array>
#include <cstddef>
#include <limits>

namespace ilp {
namespace {

constexpr std::int32_t unknown_sample = std::numeric_limits<std::int32_t>::min();
constexpr int max_levels = 24;

using Level = ImageView<std::int32_t>;

struct Mean {
  std::int32_t sum = 0;
  std::int32_t count = 0;

  void add(std::int32_t sample) {
    if (sample == unknown_sample) return;
    sum += sample;
    ++count;
  }
  [[nodiscard]] std::int32_t value() const { return count == 0 ? unknown_sample : sum / count; }
};

/// Takes the mean of the known samples in each square of four.
void pull(const Level& fine, const Level& coarse) {
  for (std::int32_t y = 0; y < coarse.height; ++y) {
    const std::int32_t* upper = fine.row(2 * y);
    const std::int32_t* lower = 2 * y + 1 < fine.height ? fine.row(2 * y + 1) : nullptr;
    std::int32_t* out = coarse.row(y);
    for (std::ptrdiff_t x = 0; x < coarse.width; ++x) {
      const bool inner = 2 * x + 1 < fine.width;
      Mean mean;
      mean.add(upper[2 * x]);
      if (inner) mean.add(upper[2 * x + 1]);
      if (lower != nullptr) mean.add(lower[2 * x]);
      if (lower != nullptr && inner) mean.add(lower[2 * x + 1]);
      out[x] = mean.value();
    }
  }
}

std::int32_t clamped(std::int32_t i, std::int32_t size) {
  return i < 0 ? 0 : i < size ? i : size - 1;
}

/// Interpolates bilinearly from the coarse level, which is known everywhere, to the unknown samples of the fine one.
void push(const Level& coarse, const Level& fine) {
  for (std::int32_t y = 0; y < fine.height; ++y) {
    std::int32_t* out = fine.row(y);
    const std::int32_t* near = coarse.row(y / 2);
    const std::int32_t* far = coarse.row(clamped(y % 2 == 0 ? y / 2 - 1 : y / 2 + 1, coarse.height));
    for (std::int32_t x = 0; x < fine.width; ++x) {
      if (out[x] != unknown_sample) continue;
      const std::int32_t a = x / 2;
      const std::int32_t b = clamped(x % 2 == 0 ? a - 1 : a + 1, coarse.width);
      out[x] = (9 * near[a] + 3 * (near[b] + far[a]) + far[b] + 8) >> 4;
    }
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
    pull(fine, coarse);
    levels[count++] = coarse;
  }
  while (--count > 0) push(levels[count], levels[count - 1]);
}

}  // namespace ilp
