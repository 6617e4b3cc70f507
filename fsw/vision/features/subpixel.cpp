#include "fsw/vision/features/subpixel.hpp"

#include <cmath>

#include "fsw/base/vector_width.hpp"
#include "fsw/vision/image/small_solver.hpp"

namespace ilp {
namespace {

constexpr int unknowns = PatchTemplate::unknowns;
enum Unknown : std::size_t { xx, xy, yx, yy, shift_x, shift_y, gain };
constexpr int max_iterations = 12;
constexpr float settled_px = 0.01F;

// Eight sums side by side, joined in a fixed order: a vector unit may keep them in lanes without changing a bit.
float dot(const std::array<float, padded_patch_pixels>& p, const std::array<float, padded_patch_pixels>& q,
          std::size_t count) {
  float lanes[patch_lanes] = {};
  for (std::size_t i = 0; i < count; i += patch_lanes) {
    for (std::size_t k = 0; k < patch_lanes; ++k) lanes[k] += p[i + k] * q[i + k];
  }
  return ((lanes[0] + lanes[4]) + (lanes[1] + lanes[5])) + ((lanes[2] + lanes[6]) + (lanes[3] + lanes[7]));
}

float sum(const std::array<float, padded_patch_pixels>& p, std::size_t count) {
  float lanes[patch_lanes] = {};
  for (std::size_t i = 0; i < count; i += patch_lanes) {
    for (std::size_t k = 0; k < patch_lanes; ++k) lanes[k] += p[i + k];
  }
  return ((lanes[0] + lanes[4]) + (lanes[1] + lanes[5])) + ((lanes[2] + lanes[6]) + (lanes[3] + lanes[7]));
}

// The mean is removed in integers, so that the result is exact in float.
void centred(const std::int32_t* values, std::int32_t n, std::size_t padded,
             std::array<float, padded_patch_pixels>& out) {
  std::int32_t total = 0;  // 20 bits a value, less than 2^11 of them
  for (std::int32_t i = 0; i < n; ++i) total += values[i];
  const std::int32_t mean = total / n;
  for (std::int32_t i = 0; i < n; ++i)
    out[static_cast<std::size_t>(i)] = static_cast<float>(values[i] - mean) * (1.0F / 4096);
  for (std::size_t i = static_cast<std::size_t>(n); i < padded; ++i) out[i] = 0;
}

/// From the samples of the patch and one more pixel all around it.
bool prepare(const std::int32_t* wide, std::int32_t side, PatchTemplate& t) {
  t.side = side;
  const std::size_t padded = padded_count(side);
  const std::int32_t n = side * side, stride = side + 2;
  std::int32_t values[max_patch_pixels];
  const float unit = 2.0F / static_cast<float>(side - 1);
  for (std::int32_t v = 0; v < side; ++v) {
    const float fv = unit * static_cast<float>(v) - 1;
    for (std::int32_t u = 0; u < side; ++u) {
      const std::int32_t* const p = wide + std::ptrdiff_t{v + 1} * stride + u + 1;
      const std::size_t i = static_cast<std::size_t>(v) * static_cast<std::size_t>(side) + static_cast<std::size_t>(u);
      const float fu = unit * static_cast<float>(u) - 1;
      const float gx = static_cast<float>(p[1] - p[-1]) * (0.5F / 4096);
      const float gy = static_cast<float>(p[stride] - p[-stride]) * (0.5F / 4096);
      values[i] = *p;
      t.descent[xx][i] = gx * fu;
      t.descent[xy][i] = gx * fv;
      t.descent[yx][i] = gy * fu;
      t.descent[yy][i] = gy * fv;
      t.descent[shift_x][i] = gx;
      t.descent[shift_y][i] = gy;
    }
  }
  centred(values, n, padded, t.descent[gain]);
  for (std::size_t k = 0; k < gain; ++k) {
    for (std::size_t i = static_cast<std::size_t>(n); i < padded; ++i) t.descent[k][i] = 0;
  }
  // Removing the mean of every column eliminates the offset, which leaves seven unknowns.
  for (std::size_t k = 0; k <= gain; ++k) {
    const float mean = sum(t.descent[k], padded) / static_cast<float>(n);
    for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) t.descent[k][i] -= mean;
  }
  for (std::size_t i = 0; i <= gain; ++i) {
    for (std::size_t k = 0; k <= i; ++k) t.factor[i][k] = dot(t.descent[i], t.descent[k], padded);
  }
  t.variance_sum = t.factor[gain][gain];
  return factor_positive_definite<unknowns>(t.factor, 1e-4F);
}

/// Products of the samples of b with the descent images, and the sums that give their correlation.
struct Products {
  float step[unknowns];
  float sum, square;
};

void multiply(const PatchTemplate& a, const std::int32_t* values, std::size_t padded, Products& out) {
  std::array<float, padded_patch_pixels> b;
  centred(values, a.side * a.side, padded, b);
  for (std::size_t k = 0; k <= gain; ++k) out.step[k] = dot(a.descent[k], b, padded);
  out.sum = sum(b, padded);
  out.square = dot(b, b, padded);
}

}  // namespace

bool prepare_patch(SmoothView image, float x, float y, std::int32_t side, PatchTemplate& t) {
  // One more pixel all around for the central differences.
  constexpr std::size_t capacity = static_cast<std::size_t>(limits::max_patch_side + 2) * (limits::max_patch_side + 2);
  std::int32_t wide[capacity];
  if (!sample_patch(image, x, y, {}, side + 2, wide)) return false;
  bool regular = false;
  with_widest_vectors([&] { regular = prepare(wide, side, t); });
  return regular;
}

bool register_patch(const PatchTemplate& a, SmoothView image_b, PatchWarp& warp) {
  std::int32_t values[max_patch_pixels];
  const std::size_t padded = padded_count(a.side);
  const std::int32_t n = a.side * a.side;
  const float unit = 2.0F / static_cast<float>(a.side - 1);
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    if (!sample_patch(image_b, warp.x, warp.y, warp.linear, a.side, values)) return false;
    Products products;
    with_widest_vectors([&] { multiply(a, values, padded, products); });
    auto& step = products.step;
    const float covariance = step[gain];
    const float variance = products.square - products.sum * products.sum / static_cast<float>(n);
    if (!(variance > 0)) return false;
    warp.ncc = covariance / std::sqrt(a.variance_sum * variance);
    solve_factored<unknowns>(a.factor, step);
    if (!(step[gain] > 0)) return false;

    const float scale = 1 / step[gain];
    const float dx = step[shift_x] * scale, dy = step[shift_y] * scale;
    // I + D, D the affine part of the step; warp := warp o step^-1.
    const float k = scale * unit;
    const Linear2 s{1 + step[xx] * k, step[xy] * k, step[yx] * k, 1 + step[yy] * k};
    const float det = s.xx * s.yy - s.xy * s.yx;
    if (!(det > 0.25F && det < 4)) return false;
    const Linear2 inv{s.yy / det, -s.xy / det, -s.yx / det, s.xx / det};
    const Linear2 old = warp.linear;
    warp.linear = {old.xx * inv.xx + old.xy * inv.yx, old.xx * inv.xy + old.xy * inv.yy,
                   old.yx * inv.xx + old.yy * inv.yx, old.yx * inv.xy + old.yy * inv.yy};
    const float moved_x = warp.linear.xx * dx + warp.linear.xy * dy;
    const float moved_y = warp.linear.yx * dx + warp.linear.yy * dy;
    warp.x -= moved_x;
    warp.y -= moved_y;
    if (moved_x * moved_x + moved_y * moved_y < settled_px * settled_px) return !too_clipped(values, n);
  }
  return false;
}

}  // namespace ilp
