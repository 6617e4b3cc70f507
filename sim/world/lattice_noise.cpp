#include "sim/world/lattice_noise.hpp"

#include <cstddef>
#include <limits>

namespace ilp::sim {
namespace {

struct Gradient {
  double x, y;
};

// Eight directions of length sqrt(2), which brings the noise to [-1, 1].
constexpr double s = 1.41421356237309504880;
constexpr Gradient gradients[8] = {{1, 1}, {-1, 1}, {1, -1}, {-1, -1}, {s, 0}, {-s, 0}, {0, s}, {0, -s}};

Gradient gradient_at(std::int32_t i, std::int32_t j, std::uint32_t seed) {
  return gradients[lattice_hash(i, j, seed) >> 29U];
}

}  // namespace

void add_octave(const Octave& octave, double y_m, std::int32_t first, double spacing_m, std::span<double> row) {
  const double y = y_m / octave.wavelength_m + octave.offset_y;
  const std::int32_t j = floor_to_int(y);
  const double v = y - j;
  const double fv = quintic_fade(v);
  std::int32_t cell = std::numeric_limits<std::int32_t>::min();
  Gradient a{}, b{}, c{}, d{};
  const double cells_per_post = spacing_m / octave.wavelength_m;
  for (std::size_t k = 0; k < row.size(); ++k) {
    const double x = (first + static_cast<std::int32_t>(k)) * cells_per_post + octave.offset_x;
    const std::int32_t i = floor_to_int(x);
    if (i != cell) {
      cell = i;
      a = gradient_at(i, j, octave.seed);
      b = gradient_at(i + 1, j, octave.seed);
      c = gradient_at(i, j + 1, octave.seed);
      d = gradient_at(i + 1, j + 1, octave.seed);
    }
    const double u = x - i;
    const double fu = quintic_fade(u);
    const double at_a = a.x * u + a.y * v;
    const double at_b = b.x * (u - 1) + b.y * v;
    const double at_c = c.x * u + c.y * (v - 1);
    const double at_d = d.x * (u - 1) + d.y * (v - 1);
    const double near = at_a + (at_b - at_a) * fu;
    const double far = at_c + (at_d - at_c) * fu;
    row[k] += octave.amplitude * (near + (far - near) * fv);
  }
}

}  // namespace ilp::sim
