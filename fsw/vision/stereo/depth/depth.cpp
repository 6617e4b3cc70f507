#include "fsw/vision/stereo/depth/depth.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "cfg/limits.hpp"
#include "fsw/base/argument.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/stereo/depth/normalised_row.hpp"
#include "fsw/vision/stereo/rectify/polar_coordinates.hpp"

namespace ilp {
namespace {

constexpr float max_spread_px = 1.0F;

struct Sample {
  float disparity_px = 0;
  float sigma_px = 0;
  bool supported = false;
};

float between(float first, float second, float weight) {
  return first + weight * (second - first);
}

/// Where pixels lie in the disparity map: the upper left one of the four around each, and the weights of the others.
constexpr std::int32_t run_length = supported_bits;  ///< pixels that are processed together, a multiple of four
struct Places {
  std::int32_t at[run_length];
  std::int32_t inside[run_length];
  float wx[run_length], wy[run_length];
};
struct Samples {
  float disparity_px[run_length], sigma_px[run_length];
  std::int32_t interpolated[run_length];
};

/// Entry `i` is what lies at (x, y); nothing outside the map.
[[gnu::always_inline]] inline void locate(ImageView<const float> disparity, double x, double y, std::int32_t i,
                                          Places& places) {
  const int in = static_cast<int>(x > -0.5) & static_cast<int>(y > -0.5) & static_cast<int>(x < disparity.width - 0.5) &
                 static_cast<int>(y < disparity.height - 0.5);
  const double u = in != 0 ? x : 0.0;
  const double v = in != 0 ? y : 0.0;
  // Truncation rounds down, because what is not positive becomes 0 either way.
  const std::int32_t x0 = std::min(static_cast<std::int32_t>(u), disparity.width - 2);
  const std::int32_t y0 = std::min(static_cast<std::int32_t>(v), disparity.height - 2);
  places.at[i] = y0 * disparity.stride + x0;
  places.inside[i] = in;
  places.wx[i] = static_cast<float>(std::min(std::max(u - x0, 0.0), 1.0));
  places.wy[i] = static_cast<float>(std::min(std::max(v - y0, 0.0), 1.0));
}

/// Interpolates where all four pixels are valid and of one surface, else takes the nearest one.
void take_samples(const DisparityView& map, const Places& places, std::int32_t count, Samples& samples) {
  const float* __restrict d = map.disparity_px.data;
  const float* __restrict s = map.sigma_px.data;
  const std::int32_t stride = map.disparity_px.stride;
  for (std::int32_t i = 0; i < count; ++i) {
    const std::int32_t at = places.at[i];
    const float wx = places.wx[i];
    const float wy = places.wy[i];
    const float d00 = d[at], d01 = d[at + 1], d10 = d[at + stride], d11 = d[at + stride + 1];
    const float s00 = s[at], s01 = s[at + 1], s10 = s[at + stride], s11 = s[at + stride + 1];
    const int all_valid = static_cast<int>(s00 != 0) & static_cast<int>(s01 != 0) & static_cast<int>(s11 != 0) &
                          static_cast<int>(s10 != 0);
    const float lowest = std::min(std::min(d00, d01), std::min(d10, d11));
    const float highest = std::max(std::max(d00, d01), std::max(d10, d11));
    const int together = all_valid & static_cast<int>(highest - lowest <= max_spread_px);
    const float between_d = between(between(d00, d01, wx), between(d10, d11, wx), wy);
    const float between_s = between(between(s00, s01, wx), between(s10, s11, wx), wy);
    const float upper_d = wx >= 0.5F ? d01 : d00;
    const float lower_d = wx >= 0.5F ? d11 : d10;
    const float upper_s = wx >= 0.5F ? s01 : s00;
    const float lower_s = wx >= 0.5F ? s11 : s10;
    const float nearest_d = wy >= 0.5F ? lower_d : upper_d;
    const float nearest_s = wy >= 0.5F ? lower_s : upper_s;
    const float found_d = together != 0 ? between_d : nearest_d;
    const float found_s = together != 0 ? between_s : nearest_s;
    samples.disparity_px[i] = places.inside[i] != 0 ? found_d : 0.0F;
    samples.sigma_px[i] = places.inside[i] != 0 ? found_s : 0.0F;
    samples.interpolated[i] = together;
  }
}

/// A bit for each of `count` samples that has a supported pixel in it.
std::uint64_t find_supported(ImageView<const DisparityKind> kind, const Places& places, const Samples& samples,
                             std::int32_t count) {
  // Two of the four pixels around a sample: the left one has the lower byte.
  static_assert(std::endian::native == std::endian::little);
  const auto pair_at = [&](std::int32_t at) {
    std::uint16_t pair;
    std::memcpy(&pair, kind.data + at, sizeof pair);
    constexpr std::uint32_t supported = static_cast<std::uint8_t>(DisparityKind::supported);
    return pair & (supported << 8U | supported);
  };
  std::int32_t i = 0;
  // Nearly nowhere there is one.
  while (i < count && (pair_at(places.at[i]) | pair_at(places.at[i] + kind.stride)) == 0) ++i;
  std::uint64_t found = 0;
  for (; i < count; ++i) {
    const std::uint32_t above = pair_at(places.at[i]), below = pair_at(places.at[i] + kind.stride);
    const std::uint32_t nearest = (places.wy[i] >= 0.5F ? below : above) & (places.wx[i] >= 0.5F ? 0xFF00U : 0xFFU);
    if ((samples.interpolated[i] != 0 ? above | below : nearest) != 0) found |= std::uint64_t{1} << i;
  }
  return found;
}

Sample sample(const DisparityView& map, double x, double y) {
  Places place;
  Samples found;
  locate(map.disparity_px, x, y, 0, place);
  take_samples(map, place, 1, found);
  return {found.disparity_px[0], found.sigma_px[0], find_supported(map.kind, place, found, 1) != 0};
}

struct InverseDepth {
  double value = 0, sigma = 0;
  bool supported = false;
};

InverseDepth behind_polar(const RectifiedPair& pair, const DisparityView& map, const Vec3& q, double cotangent,
                          double azimuth) {
  const double advance = det_asinh(cotangent);
  const Sample s = sample(map, pair.focal_px * advance + pair.cx_left, polar_row(pair, azimuth));
  const double right = advance - (s.disparity_px - pair.disparity_offset_px()) / pair.focal_px;
  const double per_cotangent = std::sqrt(q.y() * q.y() + q.z() * q.z()) / pair.baseline;
  return {(cotangent - det_sinh(right)) * per_cotangent, s.sigma_px * det_cosh(right) * per_cotangent / pair.focal_px,
          s.supported};
}

/// Part of a row of the depth map.
struct Run {
  float* inverse_depth;
  float* sigma;
  std::uint64_t* supported;
};

void behind_homography(const RectifiedPair& pair, const DisparityView& map, const double* __restrict ray_x,
                       const double* __restrict ray_y, std::int32_t count, const Run& run) {
  float* __restrict out = run.inverse_depth;
  float* __restrict out_sigma = run.sigma;
  const Mat3& r = pair.rect_from_left;
  const double m[3][3] = {{r(0, 0), r(0, 1), r(0, 2)}, {r(1, 0), r(1, 1), r(1, 2)}, {r(2, 0), r(2, 1), r(2, 2)}};
  const double offset = pair.disparity_offset_px();
  const double focal_baseline = pair.focal_px * pair.baseline;
  const ImageView<const float> disparity = map.disparity_px;
  Places places;
  Samples samples;
  double per_pixel[run_length];
  for (std::int32_t i = 0; i < count; ++i) {
    const double x = ray_x[i];
    const double y = ray_y[i];
    const double q_x = m[0][0] * x + m[0][1] * y + m[0][2];
    const double q_y = m[1][0] * x + m[1][1] * y + m[1][2];
    const double q_z = m[2][0] * x + m[2][1] * y + m[2][2];
    const double scale = pair.focal_px / q_z;
    per_pixel[i] = q_z / focal_baseline;
    locate(disparity, scale * q_x + pair.cx_left, scale * q_y + pair.cy, i, places);
  }
  take_samples(map, places, count, samples);
  for (std::int32_t i = 0; i < count; ++i) {
    const double value = (samples.disparity_px[i] - offset) * per_pixel[i];
    const double error = samples.sigma_px[i] * per_pixel[i];
    const bool usable = static_cast<bool>(static_cast<int>(error > 0) & static_cast<int>(value > 0));
    out[i] = usable ? static_cast<float>(value) : 0.0F;
    out_sigma[i] = usable ? static_cast<float>(error) : 0.0F;
  }
  *run.supported = find_supported(map.kind, places, samples, count);
}

void behind_polar_run(const RectifiedPair& pair, const DisparityView& map, const double* ray_x, const double* ray_y,
                      std::int32_t count, const Run& run) {
  for (std::int32_t x = 0; x < count; ++x) {
    const Vec3 q = pair.rect_from_left * Vec3(ray_x[x], ray_y[x], 1);
    const double cotangent = cotangent_of(q);
    // It is cheaper than the azimuth, and most pixels belong to other rings.
    if (!(cotangent >= pair.sector.low_cotangent && cotangent < pair.sector.high_cotangent)) continue;
    const double azimuth = azimuth_of(q);
    if (!contains(pair.sector, cotangent, azimuth)) continue;
    const InverseDepth inverse = behind_polar(pair, map, q, cotangent, azimuth);
    const bool usable = inverse.sigma > 0 && inverse.value > 0;
    run.inverse_depth[x] = usable ? static_cast<float>(inverse.value) : 0.0F;
    run.sigma[x] = usable ? static_cast<float>(inverse.sigma) : 0.0F;
    const std::uint64_t bit = std::uint64_t{1} << x;
    *run.supported = inverse.supported ? *run.supported | bit : *run.supported & ~bit;
  }
}

void find_depths(const RectifiedPair& pair, const CameraModel& camera, const DisparityView& map, std::int32_t y_begin,
                 std::int32_t y_end, const DepthView& depth) {
  double ray_x[run_length], ray_y[run_length];
  for (std::int32_t y = y_begin; y < y_end; ++y) {
    for (std::int32_t first = 0; first < camera.width; first += run_length) {
      const std::int32_t count = std::min(run_length, camera.width - first);
      normalised_row(camera, y, first, count, ray_x, ray_y);
      const Run run{depth.inverse_depth.row(y) + first, depth.sigma.row(y) + first,
                    depth.supported.row(y) + first / supported_bits};
      if (pair.method == RectificationMethod::polar) {
        behind_polar_run(pair, map, ray_x, ray_y, count, run);
      } else {
        behind_homography(pair, map, ray_x, ray_y, count, run);
      }
    }
  }
}

}  // namespace

Status depth_rows(const RectifiedPair& pair, const CameraModel& camera, const DisparityView& map, std::int32_t y_begin,
                  std::int32_t y_end, const DepthView& depth) {
  const auto& [disparity_px, sigma_px, kind] = map;
  if (camera.width > limits::max_image_width || !same_size(depth.inverse_depth, camera) ||
      !same_size(depth.sigma, camera) || depth.supported.width != supported_words(camera.width) ||
      depth.supported.height != camera.height) {
    return out_of_range(Argument::depth_size, depth.inverse_depth.width);
  }
  if (!same_size(disparity_px, pair) || !same_size(sigma_px, pair) || !same_size(kind, pair) ||
      sigma_px.stride != disparity_px.stride || kind.stride != disparity_px.stride || pair.width < 2 ||
      pair.height < 2) {
    return out_of_range(Argument::disparity_size, disparity_px.width);
  }
  if (y_begin < 0 || y_end > camera.height || y_begin > y_end) return out_of_range(Argument::rows, y_begin);
  with_widest_vectors([&] { find_depths(pair, camera, map, y_begin, y_end, depth); });
  return {};
}

}  // namespace ilp
