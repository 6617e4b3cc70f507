#include "fsw/base/math.hpp"

#include <cmath>
#include <limits>

namespace ilp {
namespace {

// pi/2 in three parts of 33 bits each, so that n * part is exact for |n| < 2^20 (Cody and Waite 1980).
constexpr double half_pi_1 = 1.57079632673412561417e+00;
constexpr double half_pi_2 = 6.07710050630396597660e-11;
constexpr double half_pi_3 = 2.02226624871116645580e-21;

struct Reduced {
  double r;      ///< in [-pi/4, pi/4]
  int quadrant;  ///< 0 to 3
};

Reduced reduce(double x) {
  const double n = std::floor(x * (2.0 / pi) + 0.5);
  const double r = ((x - n * half_pi_1) - n * half_pi_2) - n * half_pi_3;
  return {r, static_cast<int>(static_cast<long long>(n) & 3)};
}

// Taylor series in Horner form: on [-pi/4, pi/4] the first omitted term is below 1e-18.
double sin_kernel(double r) {
  const double z = r * r;
  double p = -1.0 / 121645100408832000.0;
  p = p * z + 1.0 / 355687428096000.0;
  p = p * z - 1.0 / 1307674368000.0;
  p = p * z + 1.0 / 6227020800.0;
  p = p * z - 1.0 / 39916800.0;
  p = p * z + 1.0 / 362880.0;
  p = p * z - 1.0 / 5040.0;
  p = p * z + 1.0 / 120.0;
  p = p * z - 1.0 / 6.0;
  return r + r * z * p;
}

double cos_kernel(double r) {
  const double z = r * r;
  double p = 1.0 / 20922789888000.0;
  p = p * z - 1.0 / 87178291200.0;
  p = p * z + 1.0 / 479001600.0;
  p = p * z - 1.0 / 3628800.0;
  p = p * z + 1.0 / 40320.0;
  p = p * z - 1.0 / 720.0;
  p = p * z + 1.0 / 24.0;
  const double half = 0.5 * z;
  return (1.0 - half) + z * z * p;
}

// atan on [0, tan(pi/16)]: argument reduced twice with atan(x) = 2 atan(x / (1 + sqrt(1 + x^2))).
double atan_positive(double x) {
  double t = x / (1.0 + std::sqrt(1.0 + x * x));
  t = t / (1.0 + std::sqrt(1.0 + t * t));
  const double z = t * t;
  double p = 0.0;
  for (int k = 23; k >= 1; k -= 2) p = 1.0 / k - z * p;
  return 4.0 * t * p;
}

}  // namespace

double det_sin(double x) {
  const Reduced q = reduce(x);
  const double value = (q.quadrant & 1) != 0 ? cos_kernel(q.r) : sin_kernel(q.r);
  return (q.quadrant & 2) != 0 ? -value : value;
}

double det_cos(double x) {
  const Reduced q = reduce(x);
  const double value = (q.quadrant & 1) != 0 ? sin_kernel(q.r) : cos_kernel(q.r);
  return q.quadrant == 1 || q.quadrant == 2 ? -value : value;
}

double det_atan2(double y, double x) {
  const double ax = std::fabs(x);
  const double ay = std::fabs(y);
  if (ax == 0.0 && ay == 0.0) return 0.0;
  double angle = ay <= ax ? atan_positive(ay / ax) : pi / 2 - atan_positive(ax / ay);
  if (x < 0) angle = pi - angle;
  return y < 0 ? -angle : angle;
}

double det_acos(double x) {
  const double c = x > 1 ? 1 : (x < -1 ? -1 : x);
  return det_atan2(std::sqrt((1 - c) * (1 + c)), c);
}

double det_asin(double x) {
  const double s = x > 1 ? 1 : (x < -1 ? -1 : x);
  return det_atan2(s, std::sqrt((1 - s) * (1 + s)));
}

double det_exp(double x) {
  if (x > 709.7) return std::numeric_limits<double>::max();
  if (x < -745.0) return 0.0;
  constexpr double ln2_high = 6.93147180369123816490e-01;
  constexpr double ln2_low = 1.90821492927058770002e-10;
  const double n = std::floor(x / (ln2_high + ln2_low) + 0.5);
  const double r = (x - n * ln2_high) - n * ln2_low;
  double p = 1.0;
  for (int k = 14; k >= 1; --k) p = 1.0 + r / k * p;
  return std::ldexp(p, static_cast<int>(n));
}

double det_log(double x) {
  if (!(x > 0)) return -std::numeric_limits<double>::infinity();
  int exponent = 0;
  double m = std::frexp(x, &exponent);
  constexpr double half_sqrt2 = 0.70710678118654752440;
  if (m < half_sqrt2) {
    m *= 2;
    --exponent;
  }
  // log m = 2 atanh(s), s = (m-1)/(m+1), |s| < 0.1716
  const double s = (m - 1) / (m + 1);
  const double z = s * s;
  double p = 0.0;
  for (int k = 21; k >= 1; k -= 2) p = 1.0 / k + z * p;
  constexpr double ln2_high = 6.93147180369123816490e-01;
  constexpr double ln2_low = 1.90821492927058770002e-10;
  return exponent * ln2_high + (2 * s * p + exponent * ln2_low);
}

double det_pow(double base, double exponent) {
  return det_exp(exponent * det_log(base));
}

double det_cbrt(double x) {
  if (x == 0) return 0;
  const double a = std::fabs(x);
  double y = det_exp(det_log(a) / 3);
  for (int i = 0; i < 2; ++i) y -= (y * y * y - a) / (3 * y * y);
  return x < 0 ? -y : y;
}

}  // namespace ilp
