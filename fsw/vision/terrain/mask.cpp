#include "fsw/vision/terrain/mask.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <type_traits>

#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/stereo/depth/normalised_row.hpp"

namespace ilp {
namespace {

// A magnification by more than four is an error, or the next pair has little in common with this one.
constexpr double max_footprint_px = 4;

/// Fills the inverse depths of a row: every gap takes the nearest valid value, or `fallback` when the row has none.
void fill_row(const float* inverse_depth, const float* sigma, std::int32_t width, float fallback, float* out) {
  std::int32_t left = -1;
  for (std::int32_t x = 0; x < width; ++x) {
    if (!(sigma[x] > 0)) continue;
    const std::int32_t middle = left < 0 ? 0 : (left + x + 1) / 2;
    for (std::int32_t i = left + 1; i < middle; ++i) out[i] = inverse_depth[left];
    for (std::int32_t i = middle; i <= x; ++i) out[i] = inverse_depth[x];
    left = x;
  }
  const float last = left < 0 ? fallback : inverse_depth[left];
  for (std::int32_t i = left + 1; i < width; ++i) out[i] = last;
}

float mean_inverse_depth(ImageView<const float> inverse_depth, ImageView<const float> sigma) {
  double sum = 0;
  std::int64_t count = 0;
  for (std::int32_t y = 0; y < sigma.height; ++y) {
    for (std::int32_t x = 0; x < sigma.width; ++x) {
      if (!(sigma.at(x, y) > 0)) continue;
      sum += static_cast<double>(inverse_depth.at(x, y));
      ++count;
    }
  }
  return count == 0 ? 0.0F : static_cast<float>(sum / static_cast<double>(count));
}

/// A pixel with at least five of its eight neighbours hit takes the quality of one of them: straight borders stay where
/// they are.
void close_holes(const std::uint8_t* in, std::int32_t width, std::int32_t height, std::uint8_t* out) {
  std::copy_n(in, static_cast<std::ptrdiff_t>(width) * height, out);
  constexpr int enough = 5;
  for (std::int32_t y = 1; y + 1 < height; ++y) {
    const std::uint8_t* b = in + static_cast<std::ptrdiff_t>(y) * width;
    const std::uint8_t* a = b - width;
    const std::uint8_t* c = b + width;
    std::uint8_t* o = out + static_cast<std::ptrdiff_t>(y) * width;
    for (std::int32_t x = 1; x + 1 < width; ++x) {
      const int neighbours = (a[x - 1] != 0) + (a[x] != 0) + (a[x + 1] != 0) + (b[x - 1] != 0) + (b[x + 1] != 0) +
                             (c[x - 1] != 0) + (c[x] != 0) + (c[x + 1] != 0);
      // Of five neighbours one is beside the pixel, above or below it.
      const std::uint8_t near = std::max(std::max(a[x], c[x]), std::max(b[x - 1], b[x + 1]));
      const std::uint8_t closed = neighbours >= enough ? near : std::uint8_t{0};
      o[x] = b[x] != 0 ? b[x] : closed;
    }
  }
}

/// The pixels of an image that are covered by a pixel which is projected to `centre` with a width of `size` px: those
/// whose middles it contains, or the nearest one.
struct Footprint {
  std::int32_t begin = 0, end = 0;
};

Footprint footprint(double centre, double size, std::int32_t extent) {
  const double half = 0.5 * size;
  const double low = std::ceil(centre - half);
  const double high = std::ceil(centre + half);
  const double nearest = std::floor(centre + 0.5);
  const double begin = low < high ? low : nearest;
  const double end = low < high ? high : nearest + 1;
  return {static_cast<std::int32_t>(std::max(begin, 0.0)),
          static_cast<std::int32_t>(std::min(end, static_cast<double>(extent)))};
}

}  // namespace

std::span<const std::byte> memory_of(const Coverage& coverage) {
  const std::int64_t pixels = std::int64_t{coverage.width} * coverage.height;
  const auto used = static_cast<std::size_t>(
      std::clamp<std::int64_t>((pixels + 63) / 64, 0, static_cast<std::int64_t>(coverage.bits.size())));
  static_assert(std::is_trivially_copyable_v<Coverage>);
  return {reinterpret_cast<const std::byte*>(&coverage), offsetof(Coverage, bits) + used * sizeof(coverage.bits[0])};
}

Status clear_coverage(std::int32_t width, std::int32_t height, Coverage& coverage) {
  if (width < 1 || height < 1 || width > limits::max_image_width || height > limits::max_image_height) {
    return {StatusCode::image_too_large, width, height};
  }
  coverage.width = width;
  coverage.height = height;
  coverage.bits.fill(0);
  return clear_seen_cells(width, height, coverage.seen);
}

void drop_uncertain_depths(double largest_sigma, const DepthView& depth) {
  const auto largest = static_cast<float>(largest_sigma);
  for (std::int32_t y = 0; y < depth.sigma.height; ++y) {
    float* inverse = depth.inverse_depth.row(y);
    float* sigma = depth.sigma.row(y);
    for (std::int32_t x = 0; x < depth.sigma.width; ++x) {
      const bool seen = std::fabs(sigma[x]) <= largest * inverse[x];
      inverse[x] = seen ? inverse[x] : 0.0F;
      sigma[x] = seen ? sigma[x] : 0.0F;
    }
  }
}

Status newly_seen_mask(ImageView<const float> sigma, const Coverage& coverage, const SeenCells& now,
                       std::int32_t finer_steps, const ImageView<std::uint8_t>& mask, MaskCounts& counts) {
  if (!same_size(sigma, coverage) || !same_size(sigma, mask)) return {StatusCode::invalid_argument, 1, sigma.width};
  counts = {};
  std::array<bool, static_cast<std::size_t>(seen_cells_side(limits::max_image_width))> better{};
  std::size_t pixel = 0;
  for (std::int32_t y = 0; y < mask.height; ++y) {
    const float* s = sigma.row(y);
    std::uint8_t* m = mask.row(y);
    for (std::int32_t x = 0; y % seen_cell_px == 0 && x < mask.width; x += seen_cell_px) {
      better[static_cast<std::size_t>(x / seen_cell_px)] =
          !at_least_as_well(coverage.seen.at(x, y), now.at(x, y), finer_steps);
    }
    for (std::int32_t x = 0; x < mask.width; ++x, ++pixel) {
      const bool matched = s[x] > 0;
      const bool fresh = matched && (!coverage.at(pixel) || better[static_cast<std::size_t>(x / seen_cell_px)]);
      m[x] = fresh ? 255 : 0;
      counts.matched += matched ? 1 : 0;
      counts.newly_seen += fresh ? 1 : 0;
    }
  }
  return {};
}

Status carry_coverage(const CameraModel& camera, const PairGround& ground, const RigidTransform& next_from_reference,
                      CoverageWorkspace& w, Coverage& coverage) {
  const auto& [inverse_depth, sigma, mask, now] = ground;
  if (!same_size(camera, coverage) || !same_size(camera, sigma) || !same_size(camera, inverse_depth) ||
      !same_size(camera, mask)) {
    return {StatusCode::invalid_argument, 1, sigma.width};
  }
  const std::int32_t width = camera.width;
  const std::int32_t height = camera.height;
  const auto pixels = static_cast<std::ptrdiff_t>(width) * height;
  std::fill_n(w.hit.begin(), pixels, std::uint8_t{0});
  const float fallback = mean_inverse_depth(inverse_depth, sigma);
  std::size_t pixel = 0;
  for (std::int32_t y = 0; y < height; ++y) {
    const float* s = sigma.row(y);
    const std::uint8_t* claimed = mask.row(y);
    normalised_row(camera, y, w.ray_x.data(), w.ray_y.data());
    fill_row(inverse_depth.row(y), s, width, fallback, w.inverse_depth.data());
    for (std::int32_t x = 0; x < width; ++x, ++pixel) {
      if (!(s[x] > 0) && !coverage.at(pixel)) continue;
      const auto k = static_cast<std::size_t>(x);
      // The point scaled by its inverse depth, which stays finite at a large distance.
      const Vec3 p = next_from_reference.rotation * Vec3(w.ray_x[k], w.ray_y[k], 1) +
                     static_cast<double>(w.inverse_depth[k]) * next_from_reference.translation;
      if (!(p.z() > 1e-6)) continue;
      const Vec2 target = pixel_from_normalised(camera, Vec2(p.x() / p.z(), p.y() / p.z()));
      const std::uint8_t quality = claimed[x] != 0 ? now.at(x, y) : coverage.seen.at(x, y);
      if (!(target.x() > -0.5 && target.y() > -0.5 && target.x() < width - 0.5 && target.y() < height - 0.5)) continue;
      // The ray has depth one: from a shorter distance the pixel is larger.
      const double size = std::min(1 / p.z(), max_footprint_px);
      const Footprint columns = footprint(target.x(), size, width);
      const Footprint rows = footprint(target.y(), size, height);
      for (std::int32_t v = rows.begin; v < rows.end; ++v) {
        std::uint8_t* hit = w.hit.data() + static_cast<std::ptrdiff_t>(v) * width;
        std::fill(hit + columns.begin, hit + columns.end, quality);
      }
    }
  }
  close_holes(w.hit.data(), width, height, w.closed.data());
  close_holes(w.closed.data(), width, height, w.hit.data());
  ILP_TRY(clear_coverage(width, height, coverage));
  std::size_t i = 0;
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x, ++i) {
      if (w.hit[i] != 0) coverage.cover(x, y, w.hit[i]);
    }
  }
  return {};
}

}  // namespace ilp
