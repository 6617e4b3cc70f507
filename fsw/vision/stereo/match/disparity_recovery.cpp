#include "fsw/vision/stereo/match/disparity_recovery.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "fsw/base/vector_width.hpp"
#include "fsw/vision/stereo/cost/lanes.hpp"
#include "fsw/vision/stereo/match/correlation_peak.hpp"
#include "fsw/vision/stereo/match/flagged_columns.hpp"

namespace ilp {
namespace {

constexpr float agreement_px = 1;

struct Neighbours {
  std::array<float, 8> disparity_px{};
  int count = 0;
};

Neighbours neighbours_of(ImageView<const float> disparity_px, ImageView<const float> sigma_px, std::int32_t x,
                         std::int32_t y) {
  Neighbours found;
  for (std::int32_t v = y - 1; v <= y + 1; ++v) {
    for (std::int32_t u = x - 1; u <= x + 1; ++u) {
      if (sigma_px.at(u, v) > 0) found.disparity_px[static_cast<std::size_t>(found.count++)] = disparity_px.at(u, v);
    }
  }
  return found;
}

/// Whether any of the 3 x 3 pixels around (x, y) has a disparity: most empty pixels are inside a gap.
bool has_neighbours(ImageView<const float> sigma_px, std::int32_t x, std::int32_t y) {
  using Floats [[gnu::vector_size(16)]] = float;
  if (sigma_px.width < 4) return true;
  // Four columns that the row has; those beyond the three only make the answer less sharp.
  const std::int32_t first = std::min(x - 1, sigma_px.width - 4);
  Floats above, here, below;
  std::memcpy(&above, sigma_px.row(y - 1) + first, sizeof above);
  std::memcpy(&here, sigma_px.row(y) + first, sizeof here);
  std::memcpy(&below, sigma_px.row(y + 1) + first, sizeof below);
  return lanes::any(reinterpret_cast<lanes::I16>((above > 0) | (here > 0) | (below > 0)));
}

/// Eight at most: by insertion.
void sort_few(float* values, int count) {
  for (int i = 1; i < count; ++i) {
    const float value = values[i];
    int k = i;
    for (; k > 0 && values[k - 1] > value; --k) values[k] = values[k - 1];
    values[k] = value;
  }
}

/// The median of the neighbours, when enough of them agree with it.
bool agreed_disparity(Neighbours& neighbours, int needed, float& disparity_px) {
  if (neighbours.count < needed) return false;
  float* begin = neighbours.disparity_px.data();
  sort_few(begin, neighbours.count);
  const float median = begin[neighbours.count / 2];
  const auto agrees = [&](float d) { return std::fabs(d - median) <= agreement_px; };
  if (std::count_if(begin, begin + neighbours.count, agrees) < needed) return false;
  disparity_px = median;
  return true;
}

/// Sums over a window of the left image and its counterparts at three disparities, grey relative to 128.
struct WindowSums {
  std::int32_t left = 0, left_squares = 0;
  std::array<std::int32_t, 3> right{}, right_squares{}, products{};
};

WindowSums window_sums(const NccRows& rows, std::int32_t x, std::int32_t y, std::int32_t d) {
  constexpr std::int32_t grey_centre = 128;
  WindowSums sums;
  for (std::int32_t v = y - rows.radius; v <= y + rows.radius; ++v) {
    const std::int32_t row = std::clamp(v, 0, rows.left.height - 1);
    const std::uint8_t* left = rows.left.row(row);
    const std::uint8_t* right = rows.right.row(row);
    for (std::int32_t u = x - rows.radius; u <= x + rows.radius; ++u) {
      const std::int32_t l = left[std::clamp(u, 0, rows.left.width - 1)] - grey_centre;
      sums.left += l;
      sums.left_squares += l * l;
      for (std::int32_t k = 0; k < 3; ++k) {
        const std::int32_t r = right[std::clamp(u - (d + k - 1), 0, rows.left.width - 1)] - grey_centre;
        const auto i = static_cast<std::size_t>(k);
        sums.right[i] += r;
        sums.right_squares[i] += r * r;
        sums.products[i] += l * r;
      }
    }
  }
  return sums;
}

float deviation_of(std::int32_t sum, std::int32_t squares, float area) {
  const auto s = static_cast<float>(sum);
  return std::max(0.0F, static_cast<float>(squares) - s * s / area);
}

float correlation(const WindowSums& sums, std::size_t k, float deviation, float damping, float area) {
  const float covariance =
      static_cast<float>(sums.products[k]) - static_cast<float>(sums.left) * static_cast<float>(sums.right[k]) / area;
  const float right_deviation = deviation_of(sums.right[k], sums.right_squares[k], area);
  return covariance / std::sqrt((deviation + damping) * (right_deviation + damping));
}

CorrelationPeak correlate(const NccRows& rows, std::int32_t x, std::int32_t y, std::int32_t d, float& deviation) {
  const auto area = static_cast<float>((2 * rows.radius + 1) * (2 * rows.radius + 1));
  const WindowSums sums = window_sums(rows, x, y, d);
  deviation = deviation_of(sums.left, sums.left_squares, area);
  return {correlation(sums, 0, deviation, rows.damping, area), correlation(sums, 1, deviation, rows.damping, area),
          correlation(sums, 2, deviation, rows.damping, area)};
}

bool is_peak(const CorrelationPeak& peak) {
  return peak.at >= peak.before && peak.at >= peak.after;
}

bool in_view(const NccRows& rows, const DisparityRange& range, std::int32_t x, std::int32_t y, std::int32_t d) {
  return d > range.min_px && d < range.max_px && x - d >= 1 && x - d < rows.right.width - 1 &&
         rows.right_valid.at(x - d, y) != 0;
}

void recover(const NccRows& rows, const DisparityRange& range, const StereoParams& params, std::int32_t y,
             const ImageView<float>& disparity_px, const ImageView<float>& sigma_px) {
  if (params.recovery_neighbours == 0 || y < 1 || y >= rows.left.height - 1) return;
  const auto area = static_cast<float>((2 * rows.radius + 1) * (2 * rows.radius + 1));
  const float min_deviation = area * static_cast<float>(params.min_texture_grey * params.min_texture_grey);
  const auto min_ncc = static_cast<float>(params.recovery_min_ncc);
  const auto max_step_px = static_cast<float>(params.recovery_step_px);
  const float* sigma = sigma_px.row(y);
  const std::uint8_t* valid = rows.left_valid.row(y);
  const auto is_empty = [=](std::int32_t x) {
    return static_cast<int>(!(sigma[x] > 0)) & static_cast<int>(valid[x] != 0);
  };
  for_each_flagged(1, rows.left.width - 1, is_empty, [&](std::int32_t x) {
    if (!has_neighbours(sigma_px, x, y)) return;
    Neighbours neighbours = neighbours_of(disparity_px, sigma_px, x, y);
    float expected = 0;
    if (!agreed_disparity(neighbours, params.recovery_neighbours, expected)) return;
    auto d = static_cast<std::int32_t>(std::floor(expected + 0.5F));
    if (!in_view(rows, range, x, y, d)) return;
    float deviation = 0;
    CorrelationPeak peak = correlate(rows, x, y, d, deviation);
    if (deviation < min_deviation) return;
    if (!is_peak(peak)) {
      d += peak.after > peak.before ? 1 : -1;
      if (!in_view(rows, range, x, y, d)) return;
      peak = correlate(rows, x, y, d, deviation);
    }
    if (peak.at < min_ncc || !is_peak(peak)) return;
    const float found = static_cast<float>(d) + peak_vertex(peak);
    if (std::fabs(found - expected) > max_step_px) return;
    disparity_px.at(x, y) = found;
    sigma_px.at(x, y) = peak_sigma(peak, deviation, rows.damping, area);
  });
}

}  // namespace

void recover_row(const NccRows& rows, const DisparityRange& range, const StereoParams& params, std::int32_t y,
                 const ImageView<float>& disparity_px, const ImageView<float>& sigma_px) {
  with_widest_vectors([&] { recover(rows, range, params, y, disparity_px, sigma_px); });
}

}  // namespace ilp
