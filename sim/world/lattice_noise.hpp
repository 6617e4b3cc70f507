// Noise on integer lattices: smooth random functions of the infinite plane that are computed for any point without
// stored state. K. Perlin, "Improving noise", SIGGRAPH 2002.
#pragma once

#include <cstdint>
#include <span>

namespace ilp::world {

/// 32 well-mixed bits for a lattice point.
[[nodiscard]] constexpr std::uint32_t lattice_hash(std::int32_t x, std::int32_t y, std::uint32_t seed) {
  std::uint32_t h =
      static_cast<std::uint32_t>(x) * 0x8DA6B343U + static_cast<std::uint32_t>(y) * 0xD8163841U + seed * 0xCB1AB31FU;
  h = (h ^ (h >> 16U)) * 0x7FEB352DU;
  h = (h ^ (h >> 15U)) * 0x846CA68BU;
  return h ^ (h >> 16U);
}

/// Largest integer not above x, |x| < 2^31; std::floor is a library call on the oldest x86-64.
[[nodiscard]] constexpr std::int32_t floor_to_int(double x) {
  const auto truncated = static_cast<std::int32_t>(x);
  return truncated - (x < truncated ? 1 : 0);
}

/// Quintic from 0 at t = 0 to 1 at t = 1, with first and second derivatives 0 at both ends.
[[nodiscard]] constexpr double quintic_fade(double t) {
  return t * t * t * (t * (t * 6 - 15) + 10);
}

/// Smoothly interpolated random values of the lattice points, in [-1, 1] with a standard deviation of about 0.4.
[[nodiscard]] inline double value_noise(double x, double y, std::uint32_t seed) {
  const std::int32_t i = floor_to_int(x);
  const std::int32_t j = floor_to_int(y);
  const double u = x - i;
  const double v = y - j;
  const double fu = u * u * (3 - 2 * u);
  const double fv = v * v * (3 - 2 * v);
  const double a = lattice_hash(i, j, seed);
  const double b = lattice_hash(i + 1, j, seed);
  const double c = lattice_hash(i, j + 1, seed);
  const double d = lattice_hash(i + 1, j + 1, seed);
  const double near = a + (b - a) * fu;
  const double far = c + (d - c) * fu;
  return (near + (far - near) * fv) * (2.0 / 4294967296.0) - 1;
}

/// One octave of gradient noise.
struct Octave {
  double wavelength_m = 1;
  double amplitude = 1;
  double offset_x = 0;  ///< lattice cells; differs between octaves so that their zeros do not coincide
  double offset_y = 0;
  std::uint32_t seed = 0;
};

/// A rectangle of posts at ((first_i + i) * spacing_m, (first_j + j) * spacing_m), row by row.
struct PostGrid {
  std::int32_t first_i = 0, first_j = 0;
  std::int32_t columns = 0, rows = 0;
  double spacing_m = 1;
};

/// Adds the octave to `values`, which has columns * rows numbers. It is gradient noise in [-amplitude, amplitude] with
/// a standard deviation of about 0.35 amplitude. The value at a post does not depend on the grid's extent.
void add_octave(const Octave& octave, const PostGrid& grid, std::span<double> values);

}  // namespace ilp::world
