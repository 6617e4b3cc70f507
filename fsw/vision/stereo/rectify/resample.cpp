#include "fsw/vision/stereo/rectify/resample.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "cfg/limits.hpp"
#include "fsw/base/argument.hpp"
#include "fsw/base/math.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/stereo/rectify/polar_coordinates.hpp"

namespace ilp {
namespace {

constexpr int fraction_bits = 8;
constexpr std::int32_t fraction_one = 1 << fraction_bits;
constexpr std::int32_t run_length = 64;  ///< pixels whose coordinates are computed together

/// Distance of each column of the rectified image along the x axis: 0, 1, .. or the hyperbolic sine of its advance.
using Columns = std::array<double, static_cast<std::size_t>(limits::max_rectified_width)>;

/// A row of the rectified image as rays of the camera: (x, y, z) = start + columns[i] * step.
struct RayRow {
  double start[3];
  double step[3];
};

struct SourceRun {
  std::int32_t x[run_length];  ///< source coordinates with fraction_bits, clamped to the image
  std::int32_t y[run_length];
  std::uint8_t inside[run_length];
};

template <bool plain>
void locate(const RayRow& ray, const double* columns, std::int32_t count, const CameraModel& camera,
            const FieldOfView& view, SourceRun& run) {
  const double right = camera.width - 1;
  const double bottom = camera.height - 1;
  for (std::int32_t i = 0; i < count; ++i) {
    const double t = columns[i];
    const double z = ray.start[2] + t * ray.step[2];
    const double inverse_z = 1 / std::max(z, 1e-9);
    const double x_ray = (ray.start[0] + t * ray.step[0]) * inverse_z;
    const double y_ray = (ray.start[1] + t * ray.step[1]) * inverse_z;
    // Beyond the field of view the distortion polynomial may fold back into the image.
    const double x = std::min(std::max(x_ray, view.min_x), view.max_x);
    const double y = std::min(std::max(y_ray, view.min_y), view.max_y);
    const Distorted d = distort_point<plain>(camera, x, y);
    const double u = camera.fx * d.x + camera.cx;
    const double v = camera.fy * d.y + camera.cy;
    const double u_in = std::min(std::max(u, 0.0), right);
    const double v_in = std::min(std::max(v, 0.0), bottom);
    const int inside = static_cast<int>(u == u_in) & static_cast<int>(v == v_in) & static_cast<int>(x == x_ray) &
                       static_cast<int>(y == y_ray) & static_cast<int>(z > 0);
    // Both are positive, so truncation rounds down without a call of floor.
    const double x_rounded = u_in * fraction_one + 0.5, y_rounded = v_in * fraction_one + 0.5;
    run.x[i] = static_cast<std::int32_t>(x_rounded);
    run.y[i] = static_cast<std::int32_t>(y_rounded);
    run.inside[i] = static_cast<std::uint8_t>(-inside);
  }
}

Columns columns_of(const RectifiedPair& pair, double cx) {
  Columns columns;
  for (std::int32_t x = 0; x < pair.width; ++x) {
    columns[static_cast<std::size_t>(x)] =
        pair.method == RectificationMethod::polar ? det_sinh((x - cx) / pair.focal_px) : x;
  }
  return columns;
}

RayRow row_of(const RectifiedPair& pair, const Mat3& cam_from_rect, double cx, std::int32_t y) {
  const double v = (y - pair.cy) / pair.focal_px;
  Vec3 start = cam_from_rect * Vec3(-cx / pair.focal_px, v, 1);
  Vec3 step = cam_from_rect.col(0) / pair.focal_px;
  if (pair.method == RectificationMethod::polar) {
    start = cam_from_rect * Vec3(0, det_sin(v), det_cos(v));
    step = cam_from_rect.col(0);
  }
  return {{start.x(), start.y(), start.z()}, {step.x(), step.y(), step.z()}};
}

/// The grey values of a run. Only the loads go pixel by pixel.
void interpolate(GrayView source, const SourceRun& run, std::int32_t count, std::uint8_t* __restrict out) {
  std::int32_t offset[run_length];
  std::uint16_t across[run_length], down[run_length];
  std::uint16_t upper_left[run_length], upper_right[run_length], lower_left[run_length], lower_right[run_length];
  const auto stride = static_cast<std::int32_t>(source.stride);
  for (std::int32_t i = 0; i < count; ++i) {
    const std::int32_t x = std::min(run.x[i] >> fraction_bits, source.width - 2);
    const std::int32_t y = std::min(run.y[i] >> fraction_bits, source.height - 2);
    across[i] = static_cast<std::uint16_t>(run.x[i] - x * fraction_one);
    down[i] = static_cast<std::uint16_t>(run.y[i] - y * fraction_one);
    offset[i] = y * stride + x;
  }
#pragma GCC unroll 1
  for (std::int32_t i = 0; i < count; ++i) {
    const std::uint8_t* const p = source.data + offset[i];
    upper_left[i] = p[0];
    upper_right[i] = p[1];
    lower_left[i] = p[stride];
    lower_right[i] = p[stride + 1];
  }
  for (std::int32_t i = 0; i < count; ++i) {
    // 256 times a grey value, which fits 16 bits.
    const auto rest = static_cast<std::uint16_t>(fraction_one - across[i]);
    const auto upper = static_cast<std::uint16_t>(upper_left[i] * rest + upper_right[i] * across[i]);
    const auto lower = static_cast<std::uint16_t>(lower_left[i] * rest + lower_right[i] * across[i]);
    constexpr std::int32_t half = 1 << (2 * fraction_bits - 1);
    const std::int32_t value = upper * fraction_one + down[i] * (lower - upper);
    out[i] = static_cast<std::uint8_t>((value + half) >> (2 * fraction_bits));
  }
}

Status resample(const RectifiedPair& pair, Side side, const CameraModel& camera, GrayView source, std::int32_t y_begin,
                std::int32_t y_end, const MutableGrayView& rectified, const ImageView<std::uint8_t>& valid) {
  if (source.width != camera.width || source.height != camera.height || source.width < 2 || source.height < 2) {
    return out_of_range(Argument::image_size, source.width);
  }
  if (rectified.width != pair.width || rectified.height != pair.height || valid.width != pair.width ||
      valid.height != pair.height) {
    return out_of_range(Argument::rectified_size, rectified.width);
  }
  if (pair.width > limits::max_rectified_width) return out_of_range(Argument::rectified_size, pair.width);
  if (y_begin < 0 || y_end > pair.height || y_begin > y_end) return out_of_range(Argument::rows, y_begin);
  const Mat3 cam_from_rect = (side == Side::left ? pair.rect_from_left : pair.rect_from_right).transpose();
  const double cx = side == Side::left ? pair.cx_left : pair.cx_right;
  const Columns columns = columns_of(pair, cx);
  SourceRun run;
  for (std::int32_t y = y_begin; y < y_end; ++y) {
    const RayRow ray = row_of(pair, cam_from_rect, cx, y);
    for (std::int32_t first = 0; first < pair.width; first += run_length) {
      const std::int32_t count = std::min(run_length, pair.width - first);
      if (camera.is_plain()) {
        locate<true>(ray, columns.data() + first, count, camera, pair.field_of_view, run);
      } else {
        locate<false>(ray, columns.data() + first, count, camera, pair.field_of_view, run);
      }
      std::uint8_t* out = rectified.row(y) + first;
      interpolate(source, run, count, out);
      std::copy_n(run.inside, count, valid.row(y) + first);
    }
  }
  return {};
}

}  // namespace

Status resample_rows(const RectifiedPair& pair, Side side, const CameraModel& camera, GrayView source,
                     std::int32_t y_begin, std::int32_t y_end, const MutableGrayView& rectified,
                     const ImageView<std::uint8_t>& valid) {
  Status status;
  with_widest_vectors([&] { status = resample(pair, side, camera, source, y_begin, y_end, rectified, valid); });
  return status;
}

}  // namespace ilp
