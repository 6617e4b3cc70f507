#include "sim/host/colour_map.hpp"

#include <algorithm>
#include <cmath>

#include "sim/host/statistics.hpp"

namespace ilp::host {

Rgb viridis(double t) {
  static constexpr Rgb table[] = {{68, 1, 84},    {72, 26, 108},  {71, 47, 125},  {65, 68, 135},
                                  {57, 86, 140},  {49, 104, 142}, {42, 120, 142}, {35, 136, 142},
                                  {31, 152, 139}, {34, 168, 132}, {53, 183, 121}, {84, 197, 104},
                                  {122, 209, 81}, {165, 219, 54}, {210, 226, 27}, {253, 231, 37}};
  constexpr int last = 15;
  const double at = std::clamp(t, 0.0, 1.0) * last;
  const int i = std::min(static_cast<int>(at), last - 1);
  const double u = at - i;
  const auto mix = [u](std::uint8_t a, std::uint8_t b) { return static_cast<std::uint8_t>(a + u * (b - a) + 0.5); };
  const Rgb &a = table[i], &b = table[i + 1];
  return {mix(a.r, b.r), mix(a.g, b.g), mix(a.b, b.b)};
}

ValueRange display_range(const Raster<float>& values) {
  std::vector<double> finite;
  for (const float v : values.samples) {
    if (std::isfinite(v)) finite.push_back(v);
  }
  if (finite.empty()) return {};
  const ValueRange range{percentile(finite, 0.02), percentile(finite, 0.98)};
  return range.high > range.low ? range : ValueRange{range.low - 0.5, range.low + 0.5};
}

Raster<Rgba> colour_mapped(const Raster<float>& values, const ValueRange& range) {
  Raster<Rgba> picture(values.width, values.height);
  for (std::size_t i = 0; i < values.samples.size(); ++i) {
    if (!std::isfinite(values.samples[i])) continue;
    const Rgb c = viridis((values.samples[i] - range.low) / (range.high - range.low));
    picture.samples[i] = {c.r, c.g, c.b, 255};
  }
  return picture;
}

}  // namespace ilp::host
