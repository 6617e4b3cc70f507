#include "fsw/vision/stereo/match/patch_difference.hpp"

#include "fsw/vision/stereo/cost/lanes.hpp"

namespace ilp {
namespace {

using lanes::I16;
using lanes::U16;
using lanes::U32;
using lanes::words_at;

constexpr std::int32_t patch_side = 2 * patch_radius + 1;
// A pixel whose grey value is so far from that of the centre has no weight.
constexpr std::int32_t same_surface = 50 * quarters_per_px;
// Weights have steps of 2 grey levels, so that a weight times a difference fits into a word.
constexpr int weight_shift = 3;
static_assert(patch_side == lanes::words - 1);
static_assert((same_surface >> weight_shift) * (same_surface >> weight_shift) * most_difference < 1 << 16);

[[gnu::always_inline]] inline I16 magnitude(I16 v) {
  return v > 0 ? v : -v;
}

[[gnu::always_inline]] inline I16 likeness(I16 difference) {
  const I16 left = I16{} + std::int16_t{same_surface} - magnitude(difference);
  return (left > 0 ? left : I16{}) >> weight_shift;
}

template <typename V>
[[gnu::always_inline]] inline std::int32_t sum_of(V v) {
  std::int32_t sum = 0;
  for (std::size_t i = 0; i < sizeof v / sizeof v[0]; ++i) sum += static_cast<std::int32_t>(v[i]);
  return sum;
}

}  // namespace

bool sees_patch(const NccRows& rows, std::int32_t x, std::int32_t y, std::int32_t quarter_px) {
  const std::int32_t target = x - whole_px(quarter_px);
  // The patch, what rounding adds, and the column that interpolation and whole vectors read beyond it.
  return target > patch_radius && target < rows.right.width - 2 - patch_radius && rows.right_valid.at(target, y) != 0;
}

float patch_difference(const NccRows& rows, std::int32_t x, std::int32_t y, std::int32_t quarter_px,
                       std::int32_t brightness) {
  constexpr I16 in_patch = {-1, -1, -1, -1, -1, -1, -1, 0};
  const std::int32_t whole = -(-quarter_px >> 2);  // rounded up, so that the fraction adds to it
  const auto fraction = static_cast<std::int16_t>(whole * quarters_per_px - quarter_px);
  const auto rest = static_cast<std::int16_t>(quarters_per_px - fraction);
  const std::uint8_t* centre = rows.right.row(y) + x - whole;
  const auto left_centre = static_cast<std::int16_t>(rows.left.at(x, y) * quarters_per_px);
  const auto right_centre = static_cast<std::int16_t>(centre[0] * rest + centre[1] * fraction);
  const auto brighter = static_cast<std::int16_t>(brightness);
  U16 weights{};
  U32 even{};
  U32 odd{};
  for (std::int32_t v = y - patch_radius; v <= y + patch_radius; ++v) {
    const std::uint8_t* right = rows.right.row(v) + x - patch_radius - whole;
    const I16 l = words_at(rows.left.row(v) + x - patch_radius) * std::int16_t{quarters_per_px};
    const I16 r = words_at(right) * rest + words_at(right + 1) * fraction;
    const auto weight = reinterpret_cast<U16>(likeness(l - left_centre) * likeness(r - right_centre) & in_patch);
    const I16 difference = lanes::lower(magnitude(l - r - brighter), I16{} + std::int16_t{most_difference});
    const auto product = reinterpret_cast<U32>(weight * reinterpret_cast<U16>(difference));
    weights += weight;
    even += product & 0xFFFFU;
    odd += product >> 16U;
  }
  return static_cast<float>(sum_of(even + odd)) / static_cast<float>(sum_of(weights));
}

}  // namespace ilp
