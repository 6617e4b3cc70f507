// Finds the real roots of a cubic: the first by Newton's method from a start that always converges, the others in
// closed form.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace ilp {

/// Appends the real roots of a x^2 + b x + c to `roots`, without cancellation. Returns the new count.
inline int append_quadratic_roots(double a, double b, double c, double (&roots)[3], int count) {
  const double discriminant = b * b - 4 * a * c;
  if (!(discriminant >= 0)) return count;
  const double q = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
  if (a != 0) roots[count++] = q / a;
  if (q != 0) roots[count++] = c / q;
  return count;
}

/// A power of two between the cube root of `x` (> 0) and twice this root.
inline double power_above_cube_root(double x) {
  constexpr int bias = 1023;
  const int exponent = static_cast<int>(std::bit_cast<std::uint64_t>(x) >> 52U) - bias;
  const int third = (exponent + 3 * bias) / 3 - bias + 1;  // rounds down
  return std::bit_cast<double>(static_cast<std::uint64_t>(third + bias) << 52U);
}

/// One step of Newton's method towards a root of x^3 + b x^2 + c x + d.
inline double improved_root_of_cubic(double b, double c, double d, double x) {
  const double value = ((x + b) * x + c) * x + d;
  const double move = value / ((3 * x + 2 * b) * x + c);
  return std::isfinite(move) ? x - move : x;
}

/// A real root of x^3 + b x^2 + c x + d. If there are three, it is the one alone on its side of the inflection.
inline double real_root_of_cubic(double b, double c, double d) {
  // t^3 + slope t + offset with t = x - inflection: its roots are within 2 sqrt(|slope| / 3) + cbrt(|offset|). From
  // there, on the side of the outermost root, Newton's method approaches without turning back.
  const double inflection = -b / 3;
  const double slope = c - b * b / 3;
  const double offset = ((inflection + b) * inflection + c) * inflection + d;
  double x = inflection;
  if (offset == 0) return x;
  const double reach = 2 * std::sqrt(std::fabs(slope) / 3) + power_above_cube_root(std::fabs(offset));
  x -= std::copysign(reach, offset);
  for (int step = 0; step < 60; ++step) {
    const double next = improved_root_of_cubic(b, c, d, x);
    const double move = std::fabs(next - x);
    x = next;
    if (!(move > 1e-15 * std::fabs(x))) break;
  }
  return x;
}

/// The real roots of c[0] + c[1] x + c[2] x^2 + c[3] x^3, in no particular order; a double root is given twice. Returns
/// their number. Polynomials of a lower degree are solved too; one that is constant or not finite has no root.
inline int cubic_roots(const double (&c)[4], double (&roots)[3]) {
  const double size = std::fabs(c[0]) + std::fabs(c[1]) + std::fabs(c[2]) + std::fabs(c[3]);
  if (!(size > 0) || !std::isfinite(size)) return 0;
  constexpr double negligible = 1e-14;
  if (!(std::fabs(c[3]) > negligible * size)) return append_quadratic_roots(c[2], c[1], c[0], roots, 0);

  const double b = c[2] / c[3];
  const double d = c[1] / c[3];
  const double e = c[0] / c[3];
  const double x = roots[0] = real_root_of_cubic(b, d, e);
  const int count = append_quadratic_roots(1, x + b, (x + b) * x + d, roots, 1);
  // One step each restores what the division by the first root has lost.
  for (int i = 1; i < count; ++i) {
    const double better = improved_root_of_cubic(b, d, e, roots[i]);
    if (std::fabs(better - roots[i]) < 1e-6 * (1 + std::fabs(roots[i]))) roots[i] = better;
  }
  return count;
}

}  // namespace ilp
