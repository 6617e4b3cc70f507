#include "fsw/vision/terrain/mask.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <type_traits>

#include "fsw/base/argument.hpp"
#include "fsw/base/vector_width.hpp"
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
[[gnu::always_inline]] inline void find_footprint(double centre, double size, std::int32_t extent, std::int32_t& begin,
                                                  std::int32_t& end) {
  const double half = 0.5 * size;
  const double low = std::ceil(centre - half);
  const double high = std::ceil(centre + half);
  const double nearest = std::floor(centre + 0.5);
  const double first = low < high ? low : nearest;
  const double last = low < high ? high : nearest + 1;
  begin = static_cast<std::int32_t>(std::max(first, 0.0));
  end = static_cast<std::int32_t>(std::min(last, static_cast<double>(extent)));
}

/// Where the ground of several pixels of a row lies in the next image: columns and rows; no column where it is outside.
constexpr std::int32_t run_length = 64;
struct Footprints {
  std::int32_t column[run_length], column_end[run_length], row[run_length], row_end[run_length];
};

template <bool plain>
void project(const CameraModel& camera, const RigidTransform& next_from_reference, const double* __restrict ray_x,
             const double* __restrict ray_y, const float* __restrict inverse_depth, std::int32_t count,
             Footprints& out) {
  const Mat3& r = next_from_reference.rotation;
  const double m[3][3] = {{r(0, 0), r(0, 1), r(0, 2)}, {r(1, 0), r(1, 1), r(1, 2)}, {r(2, 0), r(2, 1), r(2, 2)}};
  const double t[3] = {next_from_reference.translation.x(), next_from_reference.translation.y(),
                       next_from_reference.translation.z()};
  const double right = camera.width - 0.5;
  const double bottom = camera.height - 0.5;
  for (std::int32_t i = 0; i < count; ++i) {
    // The point scaled by its inverse depth, which stays finite at a large distance.
    const auto inverse = static_cast<double>(inverse_depth[i]);
    const double p_x = m[0][0] * ray_x[i] + m[0][1] * ray_y[i] + m[0][2] + inverse * t[0];
    const double p_y = m[1][0] * ray_x[i] + m[1][1] * ray_y[i] + m[1][2] + inverse * t[1];
    const double p_z = m[2][0] * ray_x[i] + m[2][1] * ray_y[i] + m[2][2] + inverse * t[2];
    const int in_front = static_cast<int>(p_z > 1e-6);
    const double z = in_front != 0 ? p_z : 1.0;
    const double x = p_x / z;
    const double y = p_y / z;
    const Distorted d = distort_point<plain>(camera, x, y);
    const double u = camera.fx * d.x + camera.cx;
    const double v = camera.fy * d.y + camera.cy;
    const int in = in_front & static_cast<int>(u > -0.5) & static_cast<int>(v > -0.5) & static_cast<int>(u < right) &
                   static_cast<int>(v < bottom);
    // The ray has depth one: from a shorter distance the pixel is larger.
    const double size = std::min(1 / z, max_footprint_px);
    std::int32_t column_end = 0;
    find_footprint(in != 0 ? u : 0.0, size, camera.width, out.column[i], column_end);
    find_footprint(in != 0 ? v : 0.0, size, camera.height, out.row[i], out.row_end[i]);
    out.column_end[i] = in != 0 ? column_end : 0;
  }
}

/// Covers what the pixel sees of the next image. Nearly always that is a pixel or two.
[[gnu::always_inline]] inline void cover_footprint(const Footprints& prints, std::size_t i, std::uint8_t quality,
                                                   std::int32_t width, std::uint8_t* hit) {
  for (std::int32_t v = prints.row[i]; v < prints.row_end[i]; ++v) {
    std::uint8_t* row = hit + static_cast<std::ptrdiff_t>(v) * width;
    const std::int32_t columns = prints.column_end[i] - prints.column[i];
    // One pixel is the usual case, and not worth a call.
    if (columns == 1) {
      row[prints.column[i]] = quality;
    } else if (columns > 1) {
      std::fill_n(row + prints.column[i], columns, quality);
    }
  }
}

/// One bit for each byte that is not 0, of eight bytes.
std::uint64_t bits_of(const std::uint8_t* bytes) {
  std::uint64_t all;
  std::memcpy(&all, bytes, sizeof all);
  constexpr std::uint64_t low = 0x7F7F7F7F7F7F7F7FU;
  const std::uint64_t tops = (((all & low) + low) | all) & ~low;
  return ((tops >> 7U) * 0x0102040810204080U) >> 56U;
}

/// Quality of a cell: that of the pixel in its middle, or of the first covered one.
std::uint8_t cell_quality(const std::uint8_t* hit, std::int32_t width, std::int32_t height, std::int32_t x,
                          std::int32_t y) {
  constexpr std::int32_t middle = seen_cell_px / 2;
  if (x + middle < width && y + middle < height) {
    const std::uint8_t quality = hit[static_cast<std::ptrdiff_t>(y + middle) * width + x + middle];
    if (quality != 0) return quality;
  }
  for (std::int32_t v = y; v < std::min(y + seen_cell_px, height); ++v) {
    for (std::int32_t u = x; u < std::min(x + seen_cell_px, width); ++u) {
      const std::uint8_t quality = hit[static_cast<std::ptrdiff_t>(v) * width + u];
      if (quality != 0) return quality;
    }
  }
  return 0;
}

/// As if every covered pixel were covered by Coverage::cover, into a coverage that is clear.
void cover_all(const std::uint8_t* hit, Coverage& coverage) {
  const std::int32_t width = coverage.width;
  const std::int32_t height = coverage.height;
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  std::size_t i = 0;
  for (; i + 8 <= pixels; i += 8) coverage.bits[i >> 6U] |= bits_of(hit + i) << (i & 63U);
  for (; i < pixels; ++i) {
    if (hit[i] != 0) coverage.set(i);
  }
  for (std::int32_t y = 0; y < height; y += seen_cell_px) {
    for (std::int32_t x = 0; x < width; x += seen_cell_px) {
      coverage.seen.of(x, y) = cell_quality(hit, width, height, x, y);
    }
  }
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
      const bool seen = sigma[x] <= largest * inverse[x];
      inverse[x] = seen ? inverse[x] : 0.0F;
      sigma[x] = seen ? sigma[x] : 0.0F;
    }
  }
}

namespace {

using RowOfBytes = std::array<std::uint8_t, limits::max_image_width>;

/// Whether each of `width` pixels from `first` on is covered.
void unpack(const Coverage& coverage, std::size_t first, std::int32_t width, RowOfBytes& covered) {
  static_assert(std::endian::native == std::endian::little);
  std::int32_t x = 0;
  for (; x + 8 <= width; x += 8) {
    const std::size_t at = first + static_cast<std::size_t>(x), word = at >> 6U, shift = at & 63U;
    std::uint64_t eight = coverage.bits[word] >> shift;
    if (shift > 56) eight |= coverage.bits[word + 1] << (64 - shift);
    // Byte k keeps bit k.
    const std::uint64_t spread = ((eight & 255U) * 0x0101010101010101U) & 0x8040201008040201U;
    std::memcpy(&covered[static_cast<std::size_t>(x)], &spread, sizeof(spread));
  }
  for (; x < width; ++x)
    covered[static_cast<std::size_t>(x)] = coverage.at(first + static_cast<std::size_t>(x)) ? 1 : 0;
}

void mark_row(const float* sigma, const RowOfBytes& covered, const RowOfBytes& better, std::int32_t width,
              std::uint8_t* __restrict mask, MaskCounts& counts) {
  std::uint32_t matched = 0, fresh = 0;
  for (std::int32_t x = 0; x < width; ++x) {
    const auto i = static_cast<std::size_t>(x);
    const auto is_matched = static_cast<std::uint32_t>(sigma[x] > 0);
    const auto is_new = static_cast<std::uint32_t>(covered[i] == 0) | static_cast<std::uint32_t>(better[i] != 0);
    const std::uint32_t is_fresh = is_matched & is_new;
    mask[x] = is_fresh != 0 ? 255 : 0;
    matched += is_matched;
    fresh += is_fresh;
  }
  counts.matched += matched;
  counts.newly_seen += fresh;
}

}  // namespace

Status newly_seen_mask(ImageView<const float> sigma, const Coverage& coverage, const SeenCells& now,
                       std::int32_t finer_steps, const ImageView<std::uint8_t>& mask, MaskCounts& counts) {
  if (!same_size(sigma, coverage) || !same_size(sigma, mask)) return out_of_range(Argument::depth_size, sigma.width);
  counts = {};
  RowOfBytes covered{}, better{};
  with_widest_vectors([&] {
    std::size_t pixel = 0;
    for (std::int32_t y = 0; y < mask.height; ++y, pixel += static_cast<std::size_t>(mask.width)) {
      for (std::int32_t x = 0; y % seen_cell_px == 0 && x < mask.width; x += seen_cell_px) {
        const bool is_better = !at_least_as_well(coverage.seen.at(x, y), now.at(x, y), finer_steps);
        std::fill_n(&better[static_cast<std::size_t>(x)], std::min(seen_cell_px, mask.width - x),
                    static_cast<std::uint8_t>(is_better));
      }
      unpack(coverage, pixel, mask.width, covered);
      mark_row(sigma.row(y), covered, better, mask.width, mask.row(y), counts);
    }
  });
  return {};
}

namespace {

constexpr std::int32_t rows_of_a_slice = 120;

void carry_rows(const CameraModel& camera, const PairGround& ground, const RigidTransform& next_from_reference,
                std::int32_t end, CoverageWorkspace& w, const Coverage& coverage) {
  const auto& [inverse_depth, sigma, mask, now] = ground;
  const std::int32_t width = camera.width;
  auto pixel = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(w.next_row) * width);
  Footprints prints;
  for (std::int32_t y = w.next_row; y < end; ++y) {
    const float* s = sigma.row(y);
    const std::uint8_t* claimed = mask.row(y);
    normalised_row(camera, y, 0, camera.width, w.ray_x.data(), w.ray_y.data());
    fill_row(inverse_depth.row(y), s, width, w.fallback, w.inverse_depth.data());
    for (std::int32_t first = 0; first < width; first += run_length) {
      const std::int32_t count = std::min(run_length, width - first);
      const double* ray_x = w.ray_x.data() + first;
      const double* ray_y = w.ray_y.data() + first;
      const float* inverse = w.inverse_depth.data() + first;
      if (camera.is_plain()) {
        project<true>(camera, next_from_reference, ray_x, ray_y, inverse, count, prints);
      } else {
        project<false>(camera, next_from_reference, ray_x, ray_y, inverse, count, prints);
      }
      for (std::int32_t i = 0; i < count; ++i, ++pixel) {
        const std::int32_t x = first + i;
        if (!(s[x] > 0) && !coverage.at(pixel)) continue;
        const std::uint8_t quality = claimed[x] != 0 ? now.at(x, y) : coverage.seen.at(x, y);
        cover_footprint(prints, static_cast<std::size_t>(i), quality, width, w.hit.data());
      }
    }
  }
  w.next_row = end;
}

Status cover_hits(const CameraModel& camera, CoverageWorkspace& w, Coverage& coverage) {
  close_holes(w.hit.data(), camera.width, camera.height, w.closed.data());
  close_holes(w.closed.data(), camera.width, camera.height, w.hit.data());
  ILP_TRY(clear_coverage(camera.width, camera.height, coverage));
  cover_all(w.hit.data(), coverage);
  return {};
}

}  // namespace

Status begin_carrying(const CameraModel& camera, const PairGround& ground, CoverageWorkspace& w,
                      const Coverage& coverage) {
  const auto& [inverse_depth, sigma, mask, now] = ground;
  if (!same_size(camera, coverage) || !same_size(camera, sigma) || !same_size(camera, inverse_depth) ||
      !same_size(camera, mask)) {
    return out_of_range(Argument::depth_size, sigma.width);
  }
  std::fill_n(w.hit.begin(), sigma.area(), std::uint8_t{0});
  w.fallback = mean_inverse_depth(inverse_depth, sigma);
  w.next_row = 0;
  return {};
}

Result<bool> carry_coverage_slice(const CameraModel& camera, const PairGround& ground,
                                  const RigidTransform& next_from_reference, CoverageWorkspace& w, Coverage& coverage) {
  if (w.next_row < camera.height) {
    const std::int32_t end = std::min(w.next_row + rows_of_a_slice, camera.height);
    with_widest_vectors([&] { carry_rows(camera, ground, next_from_reference, end, w, coverage); });
    return true;
  }
  Status status;
  with_widest_vectors([&] { status = cover_hits(camera, w, coverage); });
  ILP_TRY(status);
  return false;
}

Status carry_coverage(const CameraModel& camera, const PairGround& ground, const RigidTransform& next_from_reference,
                      CoverageWorkspace& workspace, Coverage& coverage) {
  ILP_TRY(begin_carrying(camera, ground, workspace, coverage));
  return do_all([&] { return carry_coverage_slice(camera, ground, next_from_reference, workspace, coverage); });
}

}  // namespace ilp
