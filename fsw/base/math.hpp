// Elementary functions whose last bit does not depend on the machine: plain IEEE additions and multiplications in a
// fixed order (architecture, "Determinism"). Use these in flight code instead of libm; std::sqrt, std::floor and
// std::fabs are exact and may be used directly. Errors stay below 2 units in the last place over the stated ranges, but
// for sine and cosine beyond 1e3 rad (3), the arc functions (6) and powers (1e-14 of the value).
#pragma once

namespace ilp {

inline constexpr double pi = 3.14159265358979323846;

/// |x| < 1e5 rad.
[[nodiscard]] double det_sin(double x);
[[nodiscard]] double det_cos(double x);
/// Angle of (x, y) in (-pi, pi]; det_atan2(0, 0) = 0.
[[nodiscard]] double det_atan2(double y, double x);
/// |x| <= 1, clamped.
[[nodiscard]] double det_acos(double x);
[[nodiscard]] double det_asin(double x);
/// Saturates to 0 and to the largest double.
[[nodiscard]] double det_exp(double x);
/// x > 0; -infinity for x <= 0.
[[nodiscard]] double det_log(double x);
/// base > 0.
[[nodiscard]] double det_pow(double base, double exponent);
[[nodiscard]] double det_cbrt(double x);

}  // namespace ilp
