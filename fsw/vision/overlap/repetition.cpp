#include "fsw/vision/overlap/repetition.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/vector_width.hpp"
#include "fsw/vision/image/box_sums.hpp"

namespace ilp {
namespace {

constexpr std::int32_t box_px = 8;

using Detail = ImageView<const std::int16_t>;

// Grey values minus the mean of the box around them. Boxes are cut at the border: small images have no pixels to lose.
Detail remove_shading(GrayView image, RepetitionWorkspace& w) {
  const ImageView<std::int32_t> sums(w.sums.data(), image.width + 1, image.height + 1);
  integrate<std::uint8_t, std::int32_t>(image, sums);
  const ImageView<std::int16_t> detail(w.detail.data(), image.width, image.height);
  for (std::int32_t y = 0; y < image.height; ++y) {
    const std::uint8_t* const in = image.row(y);
    const std::int32_t y0 = std::max(y - box_px / 2, 0), y1 = std::min(y + box_px / 2, image.height);
    const std::int32_t* const upper = sums.row(y0);
    const std::int32_t* const lower = sums.row(y1);
    std::int16_t* const out = detail.row(y);
    const auto put = [&](std::int32_t x) {
      const std::int32_t x0 = std::max(x - box_px / 2, 0), x1 = std::min(x + box_px / 2, image.width);
      // Never empty: the image is two boxes wide and high at least.
      const std::int32_t count = std::max((x1 - x0) * (y1 - y0), 1);
      const std::int32_t box = lower[x1] - lower[x0] - upper[x1] + upper[x0];
      out[x] = static_cast<std::int16_t>(in[x] - (box + count / 2) / count);
    };
    const std::int32_t last = image.width - box_px / 2;
    for (std::int32_t x = 0; x < box_px / 2; ++x) put(x);
    for (std::int32_t x = last; x < image.width; ++x) put(x);
    if (y1 - y0 < box_px) {
      for (std::int32_t x = box_px / 2; x < last; ++x) put(x);
      continue;
    }
    for (std::int32_t x = box_px / 2; x < last; ++x) {
      const std::int32_t x0 = x - box_px / 2, x1 = x + box_px / 2;
      const std::int32_t box = lower[x1] - lower[x0] - upper[x1] + upper[x0];
      out[x] = static_cast<std::int16_t>(in[x] - ((box + box_px * box_px / 2) >> 6));
    }
  }
  static_assert(box_px * box_px == 1 << 6);
  return detail;
}

// Large images are sampled at every fourth row, which is enough to distinguish one from a half.
double correlate(Detail d, ImageView<std::int64_t> energy, std::int32_t dx, std::int32_t dy, std::int32_t row_step) {
  const std::int32_t width = d.width - std::abs(dx), height = d.height - dy;
  const std::int32_t ax = std::max(-dx, 0), bx = std::max(dx, 0);
  std::int64_t product = 0;
  std::int32_t rows = 0;
  for (std::int32_t y = 0; y < height; y += row_step, ++rows) {
    const std::int16_t* const p = d.row(y) + ax;
    const std::int16_t* const q = d.row(y + dy) + bx;
    std::int32_t row = 0;
    for (std::int32_t x = 0; x < width; ++x) row += p[x] * q[x];
    product += row;
  }
  const double pp = static_cast<double>(box_sum(energy, ax, 0, ax + width, height));
  const double qq = static_cast<double>(box_sum(energy, bx, dy, bx + width, dy + height));
  const double quantisation = static_cast<double>(width) * height / 12;
  if (pp <= quantisation || qq <= quantisation) return 0;
  return static_cast<double>(product) * height / rows / std::sqrt(pp * qq);
}

}  // namespace

Status measure_repetition(GrayView image, RepetitionWorkspace& w, double& peak) {
  peak = 0;
  const std::int32_t side = std::max(image.width, image.height);
  if (side > repetition_max_side) return {StatusCode::image_too_large, image.width, image.height};
  if (std::min(image.width, image.height) < 2 * box_px) return {};
  const Detail detail = remove_shading(image, w);
  const ImageView<std::int64_t> energy(w.energy.data(), detail.width + 1, detail.height + 1);
  for (std::int32_t x = 0; x <= detail.width; ++x) energy.at(x, 0) = 0;
  for (std::int32_t y = 0; y < detail.height; ++y) {
    std::int64_t row = 0;
    energy.at(0, y + 1) = 0;
    for (std::int32_t x = 0; x < detail.width; ++x) {
      const std::int32_t square = detail.at(x, y) * detail.at(x, y);
      row += square;
      energy.at(x + 1, y + 1) = energy.at(x + 1, y) + row;
    }
  }

  const bool small = side <= repetition_small_side;
  const std::int32_t reach_x = small ? detail.width * 4 / 5 : repetition_reach_px;
  const std::int32_t reach_y = small ? detail.height * 4 / 5 : repetition_reach_px;
  const std::int32_t columns = 2 * reach_x + 1;
  const auto at = [&](std::int32_t dx, std::int32_t dy) -> double& {
    const std::int32_t at_shift = dy * columns + dx + reach_x;
    return w.correlation[static_cast<std::size_t>(at_shift)];
  };
  with_widest_vectors([&] {
    for (std::int32_t dy = 0; dy <= reach_y; ++dy) {
      for (std::int32_t dx = -reach_x; dx <= reach_x; ++dx) {
        const bool enough = 5 * (detail.width - std::abs(dx)) * (detail.height - dy) >= detail.width * detail.height;
        at(dx, dy) = enough ? correlate(detail, energy, dx, dy, small ? 1 : 4) : 0;
      }
    }
  });
  // The autocorrelation is symmetric about zero: the row above the first is the mirror of the one below.
  for (std::int32_t dy = 0; dy < reach_y; ++dy) {
    for (std::int32_t dx = -reach_x + 1; dx < reach_x; ++dx) {
      if (dy == 0 && dx <= 0) continue;
      const double value = at(dx, dy);
      if (value <= peak) continue;
      bool highest = true;
      for (std::int32_t k = -1; k <= 1; ++k) {
        const double above = dy > 0 ? at(dx + k, dy - 1) : at(-dx - k, 1);
        highest = highest && above <= value && at(dx + k, dy + 1) <= value && at(dx + k, dy) <= value;
      }
      if (highest) peak = value;
    }
  }
  return {};
}

}  // namespace ilp
