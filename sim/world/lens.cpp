#include "sim/world/lens.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "fsw/base/math.hpp"
#include "fsw/vision/geometry/camera.hpp"

namespace ilp::world {
namespace {

double darkening(double x, double y) {
  const double cosine2 = 1 / (1 + x * x + y * y);
  return 1 - cosine2 * cosine2;
}

/// e^-t I_n(t), n = 0 to `reach`, with t = sigma^2: the only kernel on a lattice that has exactly this variance and
/// repeats as a Gaussian does (T. Lindeberg, "Scale-space for discrete signals", PAMI 1990).
std::vector<float> gaussian(double sigma) {
  const int reach = static_cast<int>(std::ceil(4 * sigma)) + 1;
  const double half = 0.5 * sigma * sigma;
  std::vector<double> weights;
  double first = det_exp(-sigma * sigma);  // of the series of I_n
  for (int n = 0; n <= reach; ++n) {
    if (n > 0) first *= half / n;
    double sum = 0;
    double term = first;
    for (int k = 1; term > 1e-18 * sum || k < half; ++k) {
      sum += term;
      term *= half * half / (static_cast<double>(k) * (n + k));
    }
    weights.push_back(sum);
  }
  double total = weights[0];
  for (std::size_t n = 1; n < weights.size(); ++n) total += 2 * weights[n];
  std::vector<float> result(2 * weights.size() - 1);
  for (std::size_t n = 0; n < weights.size(); ++n) {
    const auto weight = static_cast<float>(weights[n] / total);
    result[weights.size() - 1 - n] = result[weights.size() - 1 + n] = weight;
  }
  return result;
}

/// out = in convolved with `weights`; both have `count` values.
void convolve(const float* in, std::ptrdiff_t count, const std::vector<float>& weights, std::vector<float>& padded,
              float* out) {
  const auto reach = static_cast<std::ptrdiff_t>(weights.size() / 2);
  padded.assign(static_cast<std::size_t>(count + 2 * reach), in[0]);
  std::copy(in, in + count, padded.begin() + reach);
  std::fill(padded.end() - reach, padded.end(), in[count - 1]);
  std::fill(out, out + count, 0.0F);
  for (std::size_t k = 0; k < weights.size(); ++k) {
    const float weight = weights[k];
    const float* const shifted = padded.data() + k;
    for (std::ptrdiff_t i = 0; i < count; ++i) out[i] += weight * shifted[i];
  }
}

}  // namespace

Vignetting::Vignetting(const CameraModel& camera, double loss) {
  double farthest = 0;
  for (const double u : {0.0, camera.width - 1.0}) {
    for (const double v : {0.0, camera.height - 1.0}) {
      const Vec2 n = normalised_from_pixel(camera, Vec2(u, v));
      farthest = std::max(farthest, darkening(n.x(), n.y()));
    }
  }
  scale_ = loss / farthest;
}

double Vignetting::share(const Direction& direction) const {
  return 1 - scale_ * darkening(direction.x, direction.y);
}

void blur(host::Raster<float>& radiance, double sigma_px) {
  const std::vector<float> weights = gaussian(sigma_px);
  const std::ptrdiff_t width = radiance.width;
  const std::ptrdiff_t height = radiance.height;
  std::vector<float> padded;
  std::vector<float> row(static_cast<std::size_t>(width));
  for (std::ptrdiff_t y = 0; y < height; ++y) {
    float* const begin = radiance.samples.data() + y * width;
    convolve(begin, width, weights, padded, row.data());
    std::copy(row.begin(), row.end(), begin);
  }
  // Down the columns, whole rows at a time.
  const std::vector<float> source = radiance.samples;
  const auto reach = static_cast<std::ptrdiff_t>(weights.size() / 2);
  for (std::ptrdiff_t y = 0; y < height; ++y) {
    float* const out = radiance.samples.data() + y * width;
    std::fill(out, out + width, 0.0F);
    for (std::ptrdiff_t k = -reach; k <= reach; ++k) {
      const float weight = weights[static_cast<std::size_t>(k + reach)];
      const float* const in = source.data() + std::clamp<std::ptrdiff_t>(y + k, 0, height - 1) * width;
      for (std::ptrdiff_t x = 0; x < width; ++x) out[x] += weight * in[x];
    }
  }
}

}  // namespace ilp::world
