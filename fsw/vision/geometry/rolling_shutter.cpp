#include "fsw/vision/geometry/rolling_shutter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "cfg/limits.hpp"
#include "fsw/base/argument.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/vision/geometry/camera.hpp"

namespace ilp {
namespace {

constexpr std::int32_t cell_px = 16;
constexpr std::int32_t most_nodes = limits::max_image_width / cell_px + 2;
/// Of Catmull and Rom's interpolation: one before, two behind.
constexpr std::int32_t taps = 4;
/// A shift of 10 px changes the row's time by a fiftieth of the readout: each step leaves less than a tenth.
constexpr int row_steps = 4;

struct Weights {
  float w[taps];
};

Weights weights_of(float t) {
  const float t2 = t * t, t3 = t2 * t;
  return {{0.5F * (2 * t2 - t - t3), 0.5F * (3 * t3 - 5 * t2 + 2), 0.5F * (4 * t2 - 3 * t3 + t), 0.5F * (t3 - t2)}};
}

/// Shifts from a pixel of the middle row's time to the image's own, along a row of nodes.
struct NodeRow {
  std::array<float, most_nodes> x, y;
};

/// The largest shift by rows.
double locate_nodes(const CameraModel& camera, const ImageMotion& motion, std::int32_t v, NodeRow& nodes) {
  double most = 0;
  for (std::int32_t i = 0; i * cell_px < camera.width + cell_px; ++i) {
    const double u = std::min(i * cell_px, camera.width - 1);
    const double row = std::min(v, camera.height - 1);
    const Vec2 shift = seen_pixel(camera, motion, Vec2(u, row)) - Vec2(u, row);
    nodes.x[static_cast<std::size_t>(i)] = static_cast<float>(shift.x());
    nodes.y[static_cast<std::size_t>(i)] = static_cast<float>(shift.y());
    // Not finite is too much.
    if (!(std::fabs(shift.y()) <= most)) most = std::fabs(shift.y());
    if (!(std::fabs(shift.x()) < camera.width)) most = camera.height;
  }
  return most;
}

/// Grey at (u, v) of the image.
std::uint8_t sample(const GrayView& image, float u, float v) {
  const float left = std::floor(u), top = std::floor(v);
  const Weights across = weights_of(u - left), down = weights_of(v - top);
  std::int32_t column[taps];
  for (std::int32_t i = 0; i < taps; ++i)
    column[i] = std::clamp(static_cast<std::int32_t>(left) + i - 1, 0, image.width - 1);
  float sum = 0;
  for (std::int32_t j = 0; j < taps; ++j) {
    const std::uint8_t* const grey = image.row(std::clamp(static_cast<std::int32_t>(top) + j - 1, 0, image.height - 1));
    float line = 0;
    for (std::int32_t i = 0; i < taps; ++i) line += across.w[i] * static_cast<float>(grey[column[i]]);
    sum += down.w[j] * line;
  }
  return static_cast<std::uint8_t>(std::min(std::max(sum + 0.5F, 0.0F), 255.0F));
}

}  // namespace

double row_share(const CameraModel& camera, double row) {
  return row / (camera.height - 1) - 0.5;
}

double row_time_s(const CameraModel& camera, double row) {
  return camera.readout_s * row_share(camera, row);
}

Vec2 rate_at(const ImageMotion& motion, const Vec2& normalised) {
  const double(&m)[8] = motion.m;
  const double x = normalised.x(), y = normalised.y(), w = m[6] * x + m[7] * y;
  return {m[0] * x + m[1] * y + m[2] - x * w, m[3] * x + m[4] * y + m[5] - y * w};
}

Vec2 moved(const ImageMotion& motion, double seconds, const Vec2& middle) {
  const double(&m)[8] = motion.m;
  const double x = middle.x(), y = middle.y();
  const double w = 1 + seconds * (m[6] * x + m[7] * y);
  return {(x + seconds * (m[0] * x + m[1] * y + m[2])) / w, (y + seconds * (m[3] * x + m[4] * y + m[5])) / w};
}

Vec2 moved_back(const ImageMotion& motion, double seconds, const Vec2& seen) {
  const double(&m)[8] = motion.m;
  // (I + t M) (x, y, 1) = s (seen, 1): two equations in x and y.
  const double t = seconds, u = seen.x(), v = seen.y();
  const double a = 1 + t * (m[0] - u * m[6]), b = t * (m[1] - u * m[7]), e = u - t * m[2];
  const double c = t * (m[3] - v * m[6]), d = 1 + t * (m[4] - v * m[7]), f = v - t * m[5];
  const double determinant = a * d - b * c;
  return {(d * e - b * f) / determinant, (a * f - c * e) / determinant};
}

Vec2 seen_pixel(const CameraModel& camera, const ImageMotion& motion, const Vec2& middle) {
  const Vec2 at = normalised_from_pixel(camera, middle);
  Vec2 seen = middle;
  for (int i = 0; i < row_steps; ++i)
    seen = pixel_from_normalised(camera, moved(motion, row_time_s(camera, seen.y()), at));
  return seen;
}

bool within_reach(const CameraModel& camera, const ImageMotion& motion) {
  NodeRow nodes;
  for (std::int32_t v = 0; v < camera.height + cell_px; v += cell_px) {
    if (!(locate_nodes(camera, motion, v, nodes) <= limits::max_rolling_rows - taps)) return false;
  }
  return true;
}

Result<bool> to_middle_row(const CameraModel& camera, const ImageMotion& motion, std::int32_t width,
                           std::int32_t height, std::span<std::uint8_t> storage) {
  if (width != camera.width || height != camera.height || width > limits::max_image_width) {
    return out_of_range(Argument::image_size, width);
  }
  const auto row_bytes = static_cast<std::size_t>(width);
  const std::size_t bytes = row_bytes * static_cast<std::size_t>(height);
  const std::size_t ahead = row_bytes * static_cast<std::size_t>(limits::max_rolling_rows);
  if (storage.size() < bytes + ahead) return out_of_range(Argument::image_size, height);
  if (!within_reach(camera, motion)) return false;
  // A row is written where a row was read that no later one needs.
  std::memmove(storage.data() + ahead, storage.data(), bytes);
  const GrayView image{storage.data() + ahead, width, height};
  NodeRow above, below;
  static_cast<void>(locate_nodes(camera, motion, 0, below));
  for (std::int32_t v = 0; v < image.height; ++v) {
    if (v % cell_px == 0) {
      above = below;
      static_cast<void>(locate_nodes(camera, motion, v + cell_px, below));
    }
    // The last cells are narrower.
    const std::int32_t top = v - v % cell_px;
    const auto rows = static_cast<float>(std::min(cell_px, image.height - 1 - top));
    const float down = rows > 0 ? static_cast<float>(v - top) / rows : 0.0F;
    std::uint8_t* const out = storage.data() + row_bytes * static_cast<std::size_t>(v);
    for (std::int32_t left = 0; left < image.width; left += cell_px) {
      const auto i = static_cast<std::size_t>(left / cell_px);
      const auto columns = static_cast<float>(std::min(cell_px, image.width - 1 - left));
      const auto between = [&](const std::array<float, most_nodes>& a, const std::array<float, most_nodes>& b,
                               std::size_t k) { return a[k] + down * (b[k] - a[k]); };
      const float x0 = between(above.x, below.x, i), x1 = between(above.x, below.x, i + 1);
      const float y0 = between(above.y, below.y, i), y1 = between(above.y, below.y, i + 1);
      for (std::int32_t u = left; u < std::min(left + cell_px, image.width); ++u) {
        const float right = columns > 0 ? static_cast<float>(u - left) / columns : 0.0F;
        out[u] = sample(image, static_cast<float>(u) + x0 + right * (x1 - x0),
                        static_cast<float>(v) + y0 + right * (y1 - y0));
      }
    }
  }
  return true;
}

}  // namespace ilp
