#include "fsw/vision/features/harris.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "fsw/base/argument.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/features/harris_workspace.hpp"

namespace ilp {
namespace {

// Sobel reaches one pixel, the binomial window two more.
constexpr std::int32_t reach_px = 3;
constexpr std::int32_t corners_per_bucket = 8;
constexpr float harris_constant = 0.04F;
// Of the strongest response; responses go with the fourth power of contrast.
constexpr float relative_threshold = 1e-6F;
// One sigma of white noise: the mean response that it gives is no corner.
constexpr float noise_grey_levels = 1.5F;
constexpr std::int32_t rows_of_a_slice = 160;

// Sobel: derivative along one axis, [1 2 1] along the other. Magnitude at most 4 * 255.
void sobel_row(GrayView image, std::int32_t y, HarrisWorkspace& w) {
  const std::uint8_t* const above = image.row(y - 1);
  const std::uint8_t* const here = image.row(y);
  const std::uint8_t* const below = image.row(y + 1);
  std::int16_t* const gx = w.gradient_x.data();
  std::int16_t* const gy = w.gradient_y.data();
  for (std::int32_t x = 1; x < image.width - 1; ++x) {
    const int right = above[x + 1] + 2 * here[x + 1] + below[x + 1];
    const int left = above[x - 1] + 2 * here[x - 1] + below[x - 1];
    const int bottom = below[x - 1] + 2 * below[x] + below[x + 1];
    const int top = above[x - 1] + 2 * above[x] + above[x + 1];
    gx[x] = static_cast<std::int16_t>(right - left);
    gy[x] = static_cast<std::int16_t>(bottom - top);
  }
}

// Binomial [1 4 6 4 1] of the products along the row: at most 16 * 1020^2, the fifth of it down the column 256 * 1020^2
// < 2^31.
void smoothed_products(const std::int16_t* p, const std::int16_t* q, std::int32_t width,
                       std::int32_t* __restrict product, std::int32_t* __restrict out) {
  for (std::int32_t x = 1; x < width - 1; ++x) product[x] = p[x] * q[x];
  for (std::int32_t x = reach_px; x < width - reach_px; ++x) {
    out[x] = product[x - 2] + product[x + 2] + 4 * (product[x - 1] + product[x + 1]) + 6 * product[x];
  }
}

float largest_of(const float* values, std::int32_t count) {
  constexpr std::int32_t lanes = 16;
  float largest[lanes];
  std::fill_n(largest, lanes, values[0]);
  std::int32_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    for (std::int32_t k = 0; k < lanes; ++k) largest[k] = values[i + k] > largest[k] ? values[i + k] : largest[k];
  }
  float result = *std::max_element(largest, largest + lanes);
  for (; i < count; ++i) result = std::max(result, values[i]);
  return result;
}

// Returns the strongest response of the row.
float response_row(std::int32_t width, std::int32_t y, const HarrisWorkspace& w, float* out) {
  const auto row = [y](const auto& ring, std::int32_t k) {
    return ring[static_cast<std::size_t>(y + k) % HarrisWorkspace::window].data();
  };
  const std::int32_t *x0 = row(w.tensor_xx, -2), *x1 = row(w.tensor_xx, -1), *x2 = row(w.tensor_xx, 0),
                     *x3 = row(w.tensor_xx, 1), *x4 = row(w.tensor_xx, 2);
  const std::int32_t *m0 = row(w.tensor_xy, -2), *m1 = row(w.tensor_xy, -1), *m2 = row(w.tensor_xy, 0),
                     *m3 = row(w.tensor_xy, 1), *m4 = row(w.tensor_xy, 2);
  const std::int32_t *y0 = row(w.tensor_yy, -2), *y1 = row(w.tensor_yy, -1), *y2 = row(w.tensor_yy, 0),
                     *y3 = row(w.tensor_yy, 1), *y4 = row(w.tensor_yy, 2);
  for (std::int32_t x = reach_px; x < width - reach_px; ++x) {
    const auto xx = static_cast<float>(x0[x] + x4[x] + 4 * (x1[x] + x3[x]) + 6 * x2[x]);
    const auto xy = static_cast<float>(m0[x] + m4[x] + 4 * (m1[x] + m3[x]) + 6 * m2[x]);
    const auto yy = static_cast<float>(y0[x] + y4[x] + 4 * (y1[x] + y3[x]) + 6 * y2[x]);
    const float trace = xx + yy;
    out[x] = xx * yy - xy * xy - harris_constant * trace * trace;
  }
  return largest_of(out + reach_px, width - 2 * reach_px);
}

// Response of the next rows, without a margin of reach_px around the image.
void respond(GrayView image, std::int32_t end, HarrisWorkspace& w) {
  for (std::int32_t y = w.progress.next_row; y < end; ++y) {
    sobel_row(image, y, w);
    const std::size_t slot = static_cast<std::size_t>(y) % HarrisWorkspace::window;
    const std::int16_t* const gx = w.gradient_x.data();
    const std::int16_t* const gy = w.gradient_y.data();
    smoothed_products(gx, gx, image.width, w.product.data(), w.tensor_xx[slot].data());
    smoothed_products(gx, gy, image.width, w.product.data(), w.tensor_xy[slot].data());
    smoothed_products(gy, gy, image.width, w.product.data(), w.tensor_yy[slot].data());
    const std::int32_t centre = y - 2;
    if (centre < reach_px) continue;
    float* const out = w.response.data() + static_cast<std::ptrdiff_t>(centre) * image.width;
    w.progress.strongest = std::max(w.progress.strongest, response_row(image.width, centre, w, out));
  }
  w.progress.next_row = end;
}

void compute_response(GrayView image, std::int32_t end, HarrisWorkspace& w) {
  with_widest_vectors([&] { respond(image, end, w); });
}

struct Region {
  std::int32_t x0, y0, x1, y1;
};

using Lanes [[gnu::vector_size(32)]] = float;
using Found [[gnu::vector_size(32)]] = std::int32_t;

/// Masks of the places of a row of a neighbourhood, in whole vectors: those with the middle at `left`, those before it
/// and those behind it.
struct Neighbours {
  static constexpr std::int32_t lanes = 8, vectors = 2;
  Found all[vectors], before[vectors], behind[vectors];

  Neighbours(std::int32_t left, std::int32_t right) {
    for (std::int32_t k = 0; k < vectors; ++k) {
      const Found place = Found{0, 1, 2, 3, 4, 5, 6, 7} + k * lanes;
      all[k] = place <= left + right;
      before[k] = place < left;
      behind[k] = (place > left) & all[k];
    }
  }
};

struct AsStrong {
  static void find(const Lanes& other, float value, const Found& places, Found& found) {
    found |= (other >= value) & places;
  }
};
struct Stronger {
  static void find(const Lanes& other, float value, const Found& places, Found& found) {
    found |= (other > value) & places;
  }
};

template <typename Rule>
void compare_row(const float* row, float value, const Found* places, Found& found) {
  for (std::ptrdiff_t k = 0; k < Neighbours::vectors; ++k) {
    Lanes others;
    std::memcpy(&others, row + k * Neighbours::lanes, sizeof others);
    Rule::find(others, value, places[k], found);
  }
}

bool any(const Found& found) {
  std::uint64_t parts[4];
  std::memcpy(parts, &found, sizeof parts);
  return ((parts[0] | parts[1]) | (parts[2] | parts[3])) != 0;
}

// True when no neighbour within `radius` is stronger; among equals the first in reading order wins. The nearest rows
// come first, because they decide most often.
bool is_maximum(const ImageView<const float>& response, std::int32_t x, std::int32_t y, std::int32_t radius,
                const Region& valid) {
  const float value = response.at(x, y);
  const std::int32_t left = std::min(radius, x - valid.x0), right = std::min(radius, valid.x1 - 1 - x);
  const std::int32_t above = std::min(radius, y - valid.y0), below = std::min(radius, valid.y1 - 1 - y);
  const std::int32_t x0 = x - left, end = response.width * response.height;
  constexpr std::int32_t whole = Neighbours::lanes * Neighbours::vectors;
  // Whole vectors would leave the memory of the image only in its last row.
  if (left + right < whole && (y + below) * response.width + x0 + whole <= end) {
    const Neighbours near(left, right);
    Found found{};
    compare_row<AsStrong>(response.row(y) + x0, value, near.before, found);
    compare_row<Stronger>(response.row(y) + x0, value, near.behind, found);
    for (std::int32_t k = 1; k <= radius; ++k) {
      if (k <= above) compare_row<AsStrong>(response.row(y - k) + x0, value, near.all, found);
      if (k <= below) compare_row<Stronger>(response.row(y + k) + x0, value, near.all, found);
      if (any(found)) return false;
    }
    return true;
  }
  for (std::int32_t v = y - above; v <= y + below; ++v) {
    const float* const row = response.row(v);
    for (std::int32_t u = x - left; u <= x + right; ++u) {
      if (row[u] > value || (row[u] == value && (v < y || (v == y && u < x)))) return false;
    }
  }
  return true;
}

using ColumnMaxima = std::array<float, static_cast<std::size_t>(limits::max_image_side)>;

// The strongest response of every column of `rows`, as far as it is above the threshold, which stands for the others.
void find_column_maxima(const ImageView<const float>& response, std::int32_t y0, std::int32_t y1, float threshold,
                        ColumnMaxima& maxima) {
  std::fill_n(maxima.begin(), response.width, threshold);
  with_widest_vectors([&] {
    float* const __restrict out = maxima.data();
    for (std::int32_t y = y0; y < y1; ++y) {
      const float* const __restrict row = response.row(y);
      for (std::int32_t x = 0; x < response.width; ++x) out[x] = row[x] > out[x] ? row[x] : out[x];
    }
  });
}

// The first place in reading order of a value of the rows from `y0` on, which columns from `x0` to `x1` have.
void find_place(const ImageView<const float>& response, const ColumnMaxima& maxima, float value, std::int32_t x0,
                std::int32_t x1, std::int32_t y0, std::int32_t& best_x, std::int32_t& best_y) {
  best_y = response.height;
  for (std::int32_t x = x0; x < x1; ++x) {
    if (maxima[static_cast<std::size_t>(x)] != value) continue;
    std::int32_t y = y0;
    while (response.at(x, y) != value) ++y;
    if (y >= best_y) continue;
    best_x = x;
    best_y = y;
  }
}

// Block-wise non-maximum suppression (A. Neubeck, L. Van Gool, "Efficient non-maximum suppression", ICPR 2006): the
// strongest of every block of (radius + 1)^2 is the only one there that can be a maximum over (2 radius + 1)^2.
std::size_t find_maxima(const ImageView<const float>& response, const Region& inner, const Region& valid,
                        std::int32_t radius, float threshold, HarrisWorkspace& w) {
  std::size_t count = 0;
  ColumnMaxima maxima;
  for (std::int32_t y0 = inner.y0; y0 < inner.y1; y0 += radius + 1) {
    find_column_maxima(response, y0, std::min(y0 + radius + 1, inner.y1), threshold, maxima);
    for (std::int32_t x0 = inner.x0; x0 < inner.x1; x0 += radius + 1) {
      const std::int32_t x1 = std::min(x0 + radius + 1, inner.x1);
      float best = threshold;
      for (std::int32_t x = x0; x < x1; ++x) best = std::max(best, maxima[static_cast<std::size_t>(x)]);
      if (!(best > threshold)) continue;
      std::int32_t x = 0, y = 0;
      find_place(response, maxima, best, x0, x1, y0, x, y);
      bool maximum = false;
      with_widest_vectors([&] { maximum = is_maximum(response, x, y, radius, valid); });
      if (!maximum) continue;
      w.found[count++] = {best, static_cast<std::int16_t>(x), static_cast<std::int16_t>(y), 0};
    }
  }
  return count;
}

bool stronger(const CornerCandidate& p, const CornerCandidate& q) {
  if (p.response != q.response) return p.response > q.response;
  return p.y != q.y ? p.y < q.y : p.x < q.x;
}

struct Buckets {
  std::int32_t side_px, columns, rows;
  [[nodiscard]] std::size_t count() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }
};

Buckets choose_buckets(GrayView image, std::int32_t target) {
  const double share = static_cast<double>(image.area()) * corners_per_bucket / target;
  Buckets b{std::max(static_cast<std::int32_t>(std::sqrt(share)), 16), 0, 0};
  do {
    b.columns = (image.width + b.side_px - 1) / b.side_px;
    b.rows = (image.height + b.side_px - 1) / b.side_px;
    b.side_px += b.side_px / 4;
  } while (b.count() > HarrisWorkspace::max_buckets);  // bound: the image; the side grows by a quarter
  b.side_px = (std::max((image.width + b.columns - 1) / b.columns, (image.height + b.rows - 1) / b.rows));
  return b;
}

// Sorts the candidates by bucket (counting sort), then every bucket by strength.
void sort_into_buckets(const Buckets& buckets, std::size_t count, HarrisWorkspace& w) {
  std::fill_n(w.bucket_begin.begin(), buckets.count() + 1, 0U);
  for (std::size_t i = 0; i < count; ++i) {
    CornerCandidate& c = w.found[i];
    c.bucket = static_cast<std::uint16_t>(c.y / buckets.side_px * buckets.columns + c.x / buckets.side_px);
    ++w.bucket_begin[c.bucket + std::size_t{1}];
  }
  for (std::size_t b = 0; b < buckets.count(); ++b) {
    w.bucket_begin[b + 1] += w.bucket_begin[b];
    w.bucket_taken[b] = w.bucket_begin[b];
  }
  for (std::size_t i = 0; i < count; ++i) w.sorted[w.bucket_taken[w.found[i].bucket]++] = w.found[i];
  for (std::size_t b = 0; b < buckets.count(); ++b) {
    CornerCandidate* const begin = w.sorted.data() + w.bucket_begin[b];
    CornerCandidate* const end = w.sorted.data() + w.bucket_begin[b + 1];
    // Heap sort, because it neither recurses nor allocates.
    std::make_heap(begin, end, stronger);
    std::sort_heap(begin, end, stronger);
  }
}

std::uint32_t bucket_size(const HarrisWorkspace& w, std::size_t b) {
  return w.bucket_begin[b + 1] - w.bucket_begin[b];
}

// Number of corners per bucket: the same for all, as far as they have them, plus the strongest remaining ones up to the
// target.
void share_out(const Buckets& buckets, std::uint32_t target, HarrisWorkspace& w) {
  std::uint32_t quota = 0, total = 0;
  for (;;) {  // bound: the corners of the fullest bucket
    std::uint32_t next_total = 0, growing = 0;
    for (std::size_t b = 0; b < buckets.count(); ++b) {
      next_total += std::min(bucket_size(w, b), quota + 1);
      growing += bucket_size(w, b) > quota ? 1U : 0U;
    }
    if (growing == 0 || next_total > target) break;
    total = next_total;
    ++quota;
  }
  std::size_t extra = 0;
  for (std::size_t b = 0; b < buckets.count(); ++b) {
    w.bucket_taken[b] = std::min(bucket_size(w, b), quota);
    if (bucket_size(w, b) > quota) w.found[extra++] = w.sorted[w.bucket_begin[b] + quota];
  }
  std::make_heap(w.found.begin(), w.found.begin() + extra, stronger);
  std::sort_heap(w.found.begin(), w.found.begin() + extra, stronger);
  for (std::size_t i = 0; i < extra && total < target; ++i, ++total) ++w.bucket_taken[w.found[i].bucket];
}

// Top of the paraboloid through the 3x3 neighbourhood of a maximum; at most half a pixel away in x and y.
Corner refine_position(const ImageView<const float>& response, const CornerCandidate& c, float strongest) {
  const float* const r0 = response.row(c.y - 1) + c.x;
  const float* const r1 = response.row(c.y) + c.x;
  const float* const r2 = response.row(c.y + 1) + c.x;
  const float gx = 0.5F * (r1[1] - r1[-1]), gy = 0.5F * (r2[0] - r0[0]);
  const float hxx = r1[1] - 2 * r1[0] + r1[-1], hyy = r2[0] - 2 * r1[0] + r0[0];
  const float hxy = 0.25F * (r2[1] - r2[-1] - r0[1] + r0[-1]);
  const float det = hxx * hyy - hxy * hxy;
  float dx = 0, dy = 0;
  if (det > 0 && hxx < 0) {
    dx = std::clamp((hxy * gy - hyy * gx) / det, -0.5F, 0.5F);
    dy = std::clamp((hxy * gx - hxx * gy) / det, -0.5F, 0.5F);
  }
  return {static_cast<float>(c.x) + dx, static_cast<float>(c.y) + dy, c.response / strongest};
}

// One more than the response's reach, because the fit needs the neighbours of a corner.
Region inner_region(GrayView image, const HarrisParams& params) {
  const std::int32_t border = std::max(params.border_px, reach_px + 1);
  return {border, border, image.width - border, image.height - border};
}

Status choose_corners(GrayView image, const HarrisParams& params, HarrisWorkspace& w, Corners& corners) {
  const Region valid{reach_px, reach_px, image.width - reach_px, image.height - reach_px};
  // White noise of variance s^2 has Sobel gradients of variance 12 s^2, and the window weighs 256.
  constexpr float noise_tensor = 256 * 12 * noise_grey_levels * noise_grey_levels;
  constexpr float noise_response = (1 - 4 * harris_constant) * noise_tensor * noise_tensor;
  const float threshold = std::max(relative_threshold * w.progress.strongest, noise_response);
  const ImageView<const float> response(w.response.data(), image.width, image.height);
  const std::size_t count =
      find_maxima(response, inner_region(image, params), valid, params.min_distance_px, threshold, w);

  const Buckets buckets = choose_buckets(image, params.target_count);
  sort_into_buckets(buckets, count, w);
  share_out(buckets, static_cast<std::uint32_t>(params.target_count), w);
  for (std::size_t b = 0; b < buckets.count(); ++b) {
    for (std::uint32_t i = 0; i < w.bucket_taken[b]; ++i) {
      const Corner corner = refine_position(response, w.sorted[w.bucket_begin[b] + i], w.progress.strongest);
      ILP_ASSERT(corners.push_back(corner), corners.size());
    }
  }
  return {};
}

}  // namespace

Status begin_corners(GrayView image, const HarrisParams& params, HarrisWorkspace& w, Corners& corners) {
  corners.clear();
  if (params.target_count < 1 || params.target_count > static_cast<std::int32_t>(limits::max_corners)) {
    return out_of_range(Argument::corner_count, params.target_count);
  }
  if (params.min_distance_px < 2 || params.min_distance_px > 64) {
    return out_of_range(Argument::corner_distance, params.min_distance_px);
  }
  if (image.area() > limits::max_image_pixels || std::max(image.width, image.height) > limits::max_image_side) {
    return {StatusCode::image_too_large, image.width, image.height};
  }
  w.progress.next_row = 1;
  w.progress.strongest = 0;
  return {};
}

Result<bool> detect_corners_slice(GrayView image, const HarrisParams& params, HarrisWorkspace& w, Corners& corners) {
  const Region inner = inner_region(image, params);
  if (inner.x1 <= inner.x0 || inner.y1 <= inner.y0) return false;
  const std::int32_t last = image.height - 1;
  if (w.progress.next_row < last) {
    compute_response(image, std::min(w.progress.next_row + rows_of_a_slice, last), w);
    return true;
  }
  ILP_TRY(choose_corners(image, params, w, corners));
  return false;
}

Status detect_corners(GrayView image, const HarrisParams& params, HarrisWorkspace& w, Corners& corners) {
  ILP_TRY(begin_corners(image, params, w, corners));
  return do_all([&] { return detect_corners_slice(image, params, w, corners); });
}

}  // namespace ilp
