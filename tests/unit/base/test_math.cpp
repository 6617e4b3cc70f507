// The machine-independent functions against libm in long double: the error in units in the last place that the header
// promises.
#include "fsw/base/math.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "fsw/base/rng.hpp"

namespace ilp {
namespace {

double ulps(double value, long double truth) {
  const double nearest = static_cast<double>(truth);
  const double unit = std::nextafter(std::fabs(nearest), std::numeric_limits<double>::infinity()) - std::fabs(nearest);
  return static_cast<double>(std::fabs(static_cast<long double>(value) - truth) / static_cast<long double>(unit));
}

double worst_ulps(double low, double high, const std::function<double(double)>& function,
                  const std::function<long double(long double)>& truth) {
  Rng rng(1);
  double worst = 0;
  for (int i = 0; i < 200000; ++i) {
    const double x = low + (high - low) * rng.uniform();
    worst = std::max(worst, ulps(function(x), truth(static_cast<long double>(x))));
  }
  return worst;
}

using Real = long double;

TEST(DetMath, SineAndCosine) {
  for (const double reach : {0.1, 1.0, 10.0, 1e3, 1e5}) {
    const double bound = reach > 1e3 ? 3 : 2;  // the argument reduction loses a bit far out
    EXPECT_LT(worst_ulps(-reach, reach, det_sin, [](Real x) { return std::sin(x); }), bound) << reach;
    EXPECT_LT(worst_ulps(-reach, reach, det_cos, [](Real x) { return std::cos(x); }), bound) << reach;
  }
  EXPECT_EQ(det_sin(0), 0);
  EXPECT_EQ(det_cos(0), 1);
  EXPECT_EQ(det_sin(1e-300), 1e-300);
}

TEST(DetMath, ArcTangentInAllQuadrants) {
  Rng rng(2);
  double worst = 0;
  for (int i = 0; i < 200000; ++i) {
    const double scale = std::exp(20 * rng.uniform() - 10);
    const double y = (2 * rng.uniform() - 1) * scale;
    const double x = 2 * rng.uniform() - 1;
    worst = std::max(worst, ulps(det_atan2(y, x), std::atan2(static_cast<Real>(y), static_cast<Real>(x))));
  }
  EXPECT_LT(worst, 5);
  EXPECT_EQ(det_atan2(0, 0), 0);
  EXPECT_EQ(det_atan2(0, 1), 0);
  EXPECT_DOUBLE_EQ(det_atan2(0, -1), pi);
  EXPECT_DOUBLE_EQ(det_atan2(1, 0), pi / 2);
  EXPECT_DOUBLE_EQ(det_atan2(-1, 0), -pi / 2);
  EXPECT_DOUBLE_EQ(det_atan2(-1, -1), -3 * pi / 4);
}

TEST(DetMath, ArcSineAndCosine) {
  EXPECT_LT(worst_ulps(-1, 1, det_asin, [](Real x) { return std::asin(x); }), 6);
  EXPECT_LT(worst_ulps(-1, 1, det_acos, [](Real x) { return std::acos(x); }), 6);
  EXPECT_EQ(det_acos(1), 0);
  EXPECT_EQ(det_acos(1.5), 0);
  EXPECT_DOUBLE_EQ(det_acos(-1.5), pi);
  EXPECT_DOUBLE_EQ(det_asin(2), pi / 2);
}

TEST(DetMath, ExponentialAndLogarithm) {
  EXPECT_LT(worst_ulps(-1, 1, det_exp, [](Real x) { return std::exp(x); }), 2);
  EXPECT_LT(worst_ulps(-700, 700, det_exp, [](Real x) { return std::exp(x); }), 2);
  EXPECT_LT(worst_ulps(0.5, 2, det_log, [](Real x) { return std::log(x); }), 2);
  EXPECT_LT(worst_ulps(1e-9, 1e9, det_log, [](Real x) { return std::log(x); }), 2);
  EXPECT_EQ(det_exp(0), 1);
  EXPECT_EQ(det_log(1), 0);
  EXPECT_EQ(det_exp(-1000), 0);
  EXPECT_EQ(det_exp(1000), std::numeric_limits<double>::max());
  EXPECT_EQ(det_log(0), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(det_log(-1), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(det_log(std::numeric_limits<double>::quiet_NaN()), -std::numeric_limits<double>::infinity());
  // Subnormal arguments and results.
  EXPECT_NEAR(det_log(1e-310) / std::log(1e-310), 1, 1e-15);
  EXPECT_NEAR(det_exp(-740) / std::exp(-740.0), 1, 0.05);
}

TEST(DetMath, PowerAndCubeRoot) {
  EXPECT_LT(worst_ulps(-1e6, 1e6, det_cbrt, [](Real x) { return std::cbrt(x); }), 2);
  EXPECT_EQ(det_cbrt(0), 0);
  EXPECT_DOUBLE_EQ(det_cbrt(-27), -3);
  // The error of the logarithm grows with the exponent: compare relatively.
  Rng rng(3);
  for (int i = 0; i < 10000; ++i) {
    const double base = 10 * rng.uniform() + 1e-3;
    const double exponent = 6 * rng.uniform() - 3;
    EXPECT_NEAR(det_pow(base, exponent) / std::pow(base, exponent), 1, 1e-14);
  }
}

TEST(DetMath, Identities) {
  Rng rng(4);
  for (int i = 0; i < 10000; ++i) {
    const double x = 20 * rng.uniform() - 10;
    EXPECT_NEAR(det_sin(x) * det_sin(x) + det_cos(x) * det_cos(x), 1, 5e-16);
    EXPECT_EQ(det_sin(-x), -det_sin(x));
    EXPECT_EQ(det_cos(-x), det_cos(x));
  }
}

}  // namespace
}  // namespace ilp
