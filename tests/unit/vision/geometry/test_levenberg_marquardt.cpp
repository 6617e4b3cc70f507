#include "fsw/vision/geometry/levenberg_marquardt.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <limits>

namespace ilp {
namespace {

using Point = Eigen::Vector2d;

/// H. H. Rosenbrock's valley: residuals 10 (y - x^2) and 1 - x, the minimum 0 at (1, 1), at the end of a bent way.
struct Valley {
  Point at{-1.2, 1};
  Point next = at;
  double invalid_below_y = -std::numeric_limits<double>::infinity();
  int tried = 0, accepted = 0;

  static Point residuals(const Point& p) { return {10 * (p.y() - p.x() * p.x()), 1 - p.x()}; }
  static double cost(const Point& p) { return 0.5 * residuals(p).squaredNorm(); }

  bool try_step(double damping, TrialStep& trial) {
    ++tried;
    Eigen::Matrix2d jacobian;
    jacobian << -20 * at.x(), 10, -1, 0;
    Eigen::Matrix2d damped = jacobian.transpose() * jacobian;
    damped.diagonal() *= 1 + damping;
    const Point step = -damped.inverse() * (jacobian.transpose() * residuals(at));
    next = at + step;
    trial.cost = next.y() < invalid_below_y ? std::numeric_limits<double>::quiet_NaN() : cost(next);
    trial.expected_gain = cost(at) - 0.5 * (residuals(at) + jacobian * step).squaredNorm();
    return true;
  }
  void accept() {
    ++accepted;
    EXPECT_LT(cost(next), cost(at));
    at = next;
  }
};

LevenbergMarquardt descend(Valley& valley, std::uint32_t max_iterations, double tolerance = 1e-12) {
  LevenbergMarquardt state{.cost = Valley::cost(valley.at)};
  while (!state.done) levenberg_marquardt_step(valley, max_iterations, tolerance, state);
  EXPECT_EQ(state.iterations, static_cast<std::uint32_t>(valley.tried));
  EXPECT_DOUBLE_EQ(state.cost, Valley::cost(valley.at));
  return state;
}

TEST(LevenbergMarquardt, FollowsABentValleyToItsEnd) {
  Valley valley;
  const LevenbergMarquardt state = descend(valley, 100);
  EXPECT_TRUE(state.converged);
  EXPECT_LT((valley.at - Point(1, 1)).norm(), 1e-9);
  EXPECT_LT(valley.accepted, valley.tried) << "a full step out of the bend leads up";
  EXPECT_LT(state.iterations, 40U);
}

TEST(LevenbergMarquardt, EndsAfterTheGivenSteps) {
  Valley valley;
  const LevenbergMarquardt state = descend(valley, 5);
  EXPECT_EQ(state.iterations, 5U);
  EXPECT_TRUE(state.done);
  EXPECT_FALSE(state.converged);
}

TEST(LevenbergMarquardt, EndsWhereAStepGainsLittle) {
  Valley rough, exact;
  EXPECT_TRUE(descend(rough, 100, 0.999).converged);
  EXPECT_TRUE(descend(exact, 100, 1e-12).converged);
  EXPECT_LT(rough.tried, exact.tried);
}

TEST(LevenbergMarquardt, StepsThatLeadNowhereAreShortened) {
  // The first undamped step leads far below.
  Valley valley{.at = {0, 0.5}, .invalid_below_y = -0.1};
  valley.next = valley.at;
  EXPECT_TRUE(descend(valley, 100).converged);
  EXPECT_LT((valley.at - Point(1, 1)).norm(), 1e-9);
}

/// Every step leads to the same.
struct Same {
  bool solvable = true;
  TrialStep step = {};
  double largest_damping = 0;
  int accepted = 0;

  bool try_step(double damping, TrialStep& trial) {
    largest_damping = damping;
    trial = step;
    return solvable;
  }
  void accept() { ++accepted; }
};

TEST(LevenbergMarquardt, GivesUpWithoutASolution) {
  Same without{.solvable = false};
  LevenbergMarquardt state{.cost = 1};
  while (!state.done) levenberg_marquardt_step(without, 1000, 1e-6, state);
  EXPECT_FALSE(state.converged);
  EXPECT_EQ(without.accepted, 0);
  EXPECT_LT(state.iterations, 20U);
  EXPECT_GT(without.largest_damping, 1e9);
}

TEST(LevenbergMarquardt, TheGainDecidesAndWithoutOneWhatWasExpected) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const struct {
    TrialStep step;
    bool accepted, converged;
  } cases[] = {
      {{2, 1e-9}, false, true},        // rounding at the minimum
      {{2, 1e-3}, false, false},       // too long a step
      {{1, 1e-3}, false, true},        //
      {{nan, 1e-9}, false, false},     // no step to judge by
      {{1 - 1e-9, 1e-3}, true, true},  //
      {{1 - 1e-3, 1e-9}, true, false},
  };
  for (const auto& given : cases) {
    Same problem{.step = given.step};
    LevenbergMarquardt state{.cost = 1};
    levenberg_marquardt_step(problem, 1000, 1e-6, state);
    const auto text = testing::Message() << "to " << given.step.cost << ", expected " << given.step.expected_gain;
    EXPECT_EQ(problem.accepted, given.accepted ? 1 : 0) << text;
    EXPECT_EQ(state.converged, given.converged) << text;
    EXPECT_EQ(state.done, given.converged) << text;
    EXPECT_EQ(state.cost, given.accepted ? given.step.cost : 1) << text;
  }
}

}  // namespace
}  // namespace ilp
