// Elementary functions whose last bit does not depend on the machine: plain IEEE additions and multiplications in a
// fixed order (architecture, "Determinism"). Use these in flight code instead of libm; std::sqrt, std::floor and
// std::fabs are exact and may be used directly. In the stated ranges errors are below 2 units in the last place, except
// for sine and cosine beyond 1e3 rad (below 3 units), the arc functions (below 6 units) and powers (below 1e-14 of the
// value).
#pragma once

namespace ilp {

inline constexpr double pi = 3.14159265358979323846;

/// x in radians, |x| < 1e5.
[[nodiscard]] double det_sin(double x);
[[nodiscard]] double det_cos(double x);
/// Angle of (x, y) in (-pi, pi]; det_atan2(0, 0) = 0.
[[nodiscard]] double det_atan2(double y, double x);
/// x is clamped to [-1, 1].
[[nodiscard]] double det_acos(double x);
[[nodiscard]] double det_asin(double x);
/// Saturates to 0 and to the largest double.
[[nodiscard]] double det_exp(double x);
/// Natural logarithm for x > 0; -infinity for x <= 0.
[[nodiscard]] double det_log(double x);
/// base > 0.
[[nodiscard]] double det_pow(double base, double exponent);
[[nodiscard]] double det_cbrt(double x);

}  // namespace ilp
