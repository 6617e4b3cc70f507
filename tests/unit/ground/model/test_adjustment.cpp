// The adjustment, its equations and its errors on models that are small enough for dense computations.

#include "sim/ground/model/adjustment.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

#include "fsw/base/rng.hpp"
#include "sim/ground/model/camera_system.hpp"
#include "sim/ground/model/pose_errors.hpp"
#include "tests/unit/ground/model/noisy_flight.hpp"
#if defined(ILP_HAVE_CERES)
#include "tests/unit/ground/model/ceres_adjustment.hpp"
#endif

namespace ilp::model {
namespace {

using Dense = std::vector<std::vector<double>>;

/// By Gauss and Jordan with the largest pivot of each column.
Dense inverse_of(Dense matrix) {
  const std::size_t n = matrix.size();
  Dense inverse(n, std::vector<double>(n, 0));
  for (std::size_t i = 0; i < n; ++i) inverse[i][i] = 1;
  for (std::size_t i = 0; i < n; ++i) {
    std::size_t pivot = i;
    for (std::size_t k = i; k < n; ++k) pivot = std::fabs(matrix[k][i]) > std::fabs(matrix[pivot][i]) ? k : pivot;
    std::swap(matrix[i], matrix[pivot]);
    std::swap(inverse[i], inverse[pivot]);
    for (std::size_t k = 0; k < n; ++k) {
      const double factor = (k == i ? matrix[i][i] - 1 : matrix[k][i]) / matrix[i][i];
      for (std::size_t j = 0; j < n; ++j) {
        matrix[k][j] -= factor * matrix[i][j];
        inverse[k][j] -= factor * inverse[i][j];
      }
    }
  }
  return inverse;
}

/// Six cameras over rolling ground; poses, points and sightings are a little off, and one sighting of 25 by 20 px.
AdjustmentProblem small_problem() {
  Rng rng(3);
  const auto off = [&](double by) { return by * (2 * rng.uniform() - 1); };
  AdjustmentProblem problem;
  for (int i = 0; i < 6; ++i) {
    const RigidTransform pose = test::looking_down(2.0 * (i % 3) + off(0.02), i < 3 ? 0 : 3, 0.4 * i + off(0.002));
    const Vec3 centre = -(pose.rotation.transpose() * pose.translation);
    problem.cameras.push_back({pose.rotation, centre, 600, 600, 320, 240});
  }
  for (int i = 0; i < 60; ++i) {
    const double x = off(6), y = off(6);
    const Vec3 point(x, y, test::ground(x, y));
    const auto number = static_cast<std::uint32_t>(problem.points.size());
    for (std::uint32_t c = 0; c < 6; ++c) {
      const AdjustedCamera& camera = problem.cameras[c];
      const Vec3 p = camera.cam_from_world * (point - camera.centre);
      const Vec2 px(600 * p.x() / p.z() + 320 + off(0.5), 600 * p.y() / p.z() + 240 + off(0.5));
      const bool wrong = (i * 6 + static_cast<int>(c)) % 25 == 24;
      problem.observations.push_back({c, number, px.x() + (wrong ? 20 : 0), px.y()});
    }
    problem.points.push_back(point + Vec3(off(0.03), off(0.03), off(0.05)));
    if (i % 10 == 0) problem.depths.push_back({2, number, 1 / (10.01 - point.z()), 0.01});
  }
  return problem;
}

TEST(CameraSystemTest, SolvesAndInvertsAsTheDenseEquations) {
  constexpr std::size_t cameras = 9, side = 6 * cameras;
  const RelatedCameras related = {{1, 8}, {2}, {3, 6}, {4}, {5}, {6}, {7, 7}, {8}, {0, 8}};
  Rng rng(5);
  CameraSystem system(related);
  Dense dense(side, std::vector<double>(side, 0));
  const auto add = [&](std::uint32_t a, std::uint32_t b, const Mat6& block) {
    system.add(a, b, block);
    const std::size_t row = std::size_t{6} * a, column = std::size_t{6} * b;
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t j = 0; j < 6; ++j) {
        const double value = block(static_cast<int>(i), static_cast<int>(j));
        dense[row + i][column + j] += value;
        if (a != b) dense[column + j][row + i] += value;
      }
    }
  };
  for (std::uint32_t a = 0; a < cameras; ++a) {
    add(a, a, 20 * Mat6::Identity());
    for (const std::uint32_t b : related[a]) {
      const Mat6 block = Mat6::NullaryExpr([&]() { return 2 * rng.uniform() - 1; });
      if (a != b) add(a, b, block);
    }
  }
  std::vector<Vec6> right(cameras);
  for (Vec6& of_camera : right) of_camera = Vec6::NullaryExpr([&]() { return rng.uniform(); });
  std::vector<Vec6> solution = right;
  ASSERT_TRUE(system.factor());
  system.solve(solution);
  const Dense inverse = inverse_of(dense);
  const std::vector<Mat6> diagonal = system.inverse_diagonal();
  for (std::size_t i = 0; i < side; ++i) {
    double expected = 0;
    for (std::size_t j = 0; j < side; ++j) expected += inverse[i][j] * right[j / 6][static_cast<int>(j % 6)];
    EXPECT_NEAR(solution[i / 6][static_cast<int>(i % 6)], expected, 1e-12);
    for (std::size_t j = 0; j < 6; ++j)
      EXPECT_NEAR(diagonal[i / 6](static_cast<int>(i % 6), static_cast<int>(j)), inverse[i][6 * (i / 6) + j], 1e-12);
  }
}

TEST(CameraSystemTest, RefusesEquationsThatLeaveSomethingFree) {
  CameraSystem system({{1}, {}});
  for (const std::uint32_t camera : {0U, 1U}) system.add(camera, camera, Mat6::Identity());
  system.add(0, 1, -Mat6::Identity());
  EXPECT_FALSE(system.factor());
}

/// Of a field of 32 by 32 cameras, each with its neighbours along the lane and in the next one, the cameras in the
/// order of their lanes or in another one.
std::size_t factor_blocks_of_field(std::uint32_t stride) {
  constexpr std::uint32_t side = 32;
  const auto camera = [&](std::uint32_t x, std::uint32_t y) { return stride * (side * y + x) % (side * side); };
  RelatedCameras related(side * side);
  for (std::uint32_t y = 0; y < side; ++y) {
    for (std::uint32_t x = 0; x < side; ++x) {
      if (x + 1 < side) related[camera(x, y)].push_back(camera(x + 1, y));
      if (y + 1 < side) related[camera(x, y)].push_back(camera(x, y + 1));
    }
  }
  return CameraSystem(related).factor_blocks();
}

// Lane after lane, the cameras of a whole lane are related to each of the next one: 32 blocks in each column. In the
// order of least fill there are 11.3, and the time of a long flight depends on it.
TEST(CameraSystemTest, EliminatesAFieldOfCamerasWithFewBlocksInAnyOrderOfTheirNumbers) {
  constexpr std::size_t cameras = 1024;
  for (const std::uint32_t stride : {1U, 389U, 1023U})
    EXPECT_LT(factor_blocks_of_field(stride), 12 * cameras) << stride;
}

#if defined(ILP_HAVE_CERES)

test::PeerProblem for_peer(const AdjustmentProblem& problem) {
  test::PeerProblem peer;
  for (const AdjustedCamera& camera : problem.cameras) {
    test::PeerCamera& one = peer.cameras.emplace_back();
    for (int i = 0; i < 9; ++i) one.cam_from_world[static_cast<std::size_t>(i)] = camera.cam_from_world(i / 3, i % 3);
    std::copy_n(camera.centre.data(), 3, one.centre.begin());
    std::tie(one.fx, one.fy, one.cx, one.cy) = std::tie(camera.fx, camera.fy, camera.cx, camera.cy);
  }
  for (const Vec3& point : problem.points) peer.points.push_back({point.x(), point.y(), point.z()});
  for (const auto& seen : problem.observations) peer.observations.push_back({seen.camera, seen.point, seen.x, seen.y});
  for (const auto& depth : problem.depths)
    peer.depths.push_back({depth.camera, depth.point, depth.inverse_depth, depth.sigma});
  const Gauge gauge = gauge_of(problem);
  peer.anchor = gauge.anchor;
  peer.component = gauge.component;
  return peer;
}

TEST(AdjustmentTest, ReachesTheMinimumThatCeresReaches) {
  AdjustmentProblem problem = small_problem();
  test::PeerProblem peer = for_peer(problem);
  const double cost = test::adjust_with_ceres(peer, 1);
  const Adjusted adjusted = adjust(problem, {1, 200, 1e-14});
  EXPECT_TRUE(adjusted.moved);
  EXPECT_NEAR(adjusted.cost, cost, 1e-10 * cost);
  for (std::size_t c = 0; c < problem.cameras.size(); ++c) {
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(problem.cameras[c].centre[k], peer.cameras[c].centre[static_cast<std::size_t>(k)], 1e-5);
  }
}

#else

TEST(AdjustmentTest, ReachesTheMinimumThatCeresReaches) {
  GTEST_SKIP() << "Ceres Solver is not installed (libceres-dev)";
}

#endif

TEST(AdjustmentTest, TheGaugeStaysWhereItIs) {
  AdjustmentProblem problem = small_problem();
  const AdjustmentProblem before = problem;
  const Gauge gauge = gauge_of(problem);
  ASSERT_TRUE(adjust(problem, {}).moved);
  EXPECT_EQ(problem.cameras[0].centre, before.cameras[0].centre);
  EXPECT_EQ(problem.cameras[0].cam_from_world, before.cameras[0].cam_from_world);
  EXPECT_EQ(problem.cameras[gauge.anchor].centre[gauge.component],
            before.cameras[gauge.anchor].centre[gauge.component]);
  EXPECT_GT((problem.cameras[1].centre - before.cameras[1].centre).norm(), 1e-4);
}

TEST(AdjustmentTest, WhereAPointLiesBehindItsCameraNothingMoves) {
  AdjustmentProblem problem = small_problem();
  problem.points[7].z() = 30;
  const AdjustmentProblem before = problem;
  EXPECT_FALSE(adjust(problem, {}).moved);
  for (std::size_t c = 0; c < problem.cameras.size(); ++c)
    EXPECT_EQ(problem.cameras[c].centre, before.cameras[c].centre);
}

/// All unknowns: rotation vector and centre of each camera, and the points.
AdjustmentProblem moved_by(AdjustmentProblem problem, std::size_t unknown, double by) {
  const std::size_t of_cameras = 6 * problem.cameras.size();
  if (unknown >= of_cameras) {
    problem.points[(unknown - of_cameras) / 3][static_cast<int>((unknown - of_cameras) % 3)] += by;
    return problem;
  }
  AdjustedCamera& camera = problem.cameras[unknown / 6];
  Vec3 move = Vec3::Zero();
  move[static_cast<int>(unknown % 3)] = by;
  if (unknown % 6 < 3) camera.cam_from_world = rotation_from_vector(move) * camera.cam_from_world;
  if (unknown % 6 >= 3) camera.centre += move;
  return problem;
}

std::vector<double> residuals_of(const AdjustmentProblem& problem, double sigma_px) {
  std::vector<double> residuals;
  for (const AdjustedObservation& seen : problem.observations) {
    const AdjustedCamera& camera = problem.cameras[seen.camera];
    const Vec3 p = camera.cam_from_world * (problem.points[seen.point] - camera.centre);
    residuals.push_back((camera.fx * p.x() / p.z() + camera.cx - seen.x) / sigma_px);
    residuals.push_back((camera.fy * p.y() / p.z() + camera.cy - seen.y) / sigma_px);
  }
  for (const AdjustedDepth& depth : problem.depths) {
    const AdjustedCamera& camera = problem.cameras[depth.camera];
    const double z = (camera.cam_from_world * (problem.points[depth.point] - camera.centre)).z();
    residuals.push_back((z * depth.inverse_depth - 1) / depth.sigma);
  }
  for (const AdjustedPrior& prior : problem.priors) {
    const AdjustedCamera& camera = problem.cameras[prior.camera];
    Eigen::Matrix<double, 6, 1> error;
    error << vector_from_rotation(camera.cam_from_world * prior.cam_from_world.transpose()),
        camera.centre - prior.centre;
    const Eigen::Matrix<double, 6, 1> px = prior.px_from_error * error;
    for (int k = 0; k < 6; ++k) residuals.push_back(px[k] / sigma_px);
  }
  return residuals;
}

/// By free unknown, the derivatives of all residuals.
Dense derivatives_of(const AdjustmentProblem& problem, double sigma_px, const std::vector<std::size_t>& free) {
  constexpr double step = 1e-5;
  Dense derivatives;
  for (const std::size_t u : free) {
    const auto ahead = residuals_of(moved_by(problem, u, step), sigma_px),
               behind = residuals_of(moved_by(problem, u, -step), sigma_px);
    std::vector<double>& derivative = derivatives.emplace_back();
    for (std::size_t i = 0; i < ahead.size(); ++i) derivative.push_back((ahead[i] - behind[i]) / (2 * step));
  }
  return derivatives;
}

Dense normal_of(const Dense& derivatives) {
  Dense normal(derivatives.size(), std::vector<double>(derivatives.size(), 0));
  for (std::size_t a = 0; a < derivatives.size(); ++a) {
    for (std::size_t b = 0; b < derivatives.size(); ++b) {
      for (std::size_t i = 0; i < derivatives[a].size(); ++i) normal[a][b] += derivatives[a][i] * derivatives[b][i];
    }
  }
  return normal;
}

/// Of the squared residuals of sightings for each degree of freedom.
double sighting_sigma(const AdjustmentProblem& problem) {
  const std::vector<double> residuals = residuals_of(problem, 1);
  double squares = 0;
  for (std::size_t i = 0; i < 2 * problem.observations.size(); ++i) squares += residuals[i] * residuals[i];
  const std::size_t unknowns = 6 * problem.cameras.size() + 3 * problem.points.size();
  return std::sqrt(squares / static_cast<double>(2 * problem.observations.size() + problem.depths.size() - unknowns));
}

TEST(PoseErrorsTest, AreThoseOfTheDenseInverse) {
  const AdjustmentProblem problem = small_problem();
  const std::size_t unknowns = 6 * problem.cameras.size() + 3 * problem.points.size();
  const Gauge gauge = gauge_of(problem);
  std::vector<std::size_t> free;
  for (std::size_t u = 6; u < unknowns; ++u) {
    if (u != 6 * gauge.anchor + 3 + static_cast<std::size_t>(gauge.component)) free.push_back(u);
  }
  const Dense inverse = inverse_of(normal_of(derivatives_of(problem, sighting_sigma(problem), free)));
  const std::vector<PoseCovariance> errors = pose_covariances(problem);
  ASSERT_EQ(errors.size(), problem.cameras.size());
  std::size_t compared = 0;
  for (std::size_t a = 0; a < free.size() && free[a] < 6 * errors.size(); ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      if (free[a] / 6 != free[b] / 6) continue;
      const std::size_t row = free[a] % 6, column = free[b] % 6;
      const double scale = std::sqrt(inverse[a][a] * inverse[b][b]);
      EXPECT_NEAR(errors[free[a] / 6][row * (row + 1) / 2 + column], inverse[a][b], 1e-5 * scale);
      ++compared;
    }
  }
  EXPECT_EQ(compared, 4 * 21U + 15U) << "five cameras, of which one has a coordinate without error";
  for (const double held : errors[0]) EXPECT_EQ(held, 0);
}

/// Three cameras are known by themselves, wrongly by some of their sigmas.
AdjustmentProblem problem_with_priors(double robust_px) {
  AdjustmentProblem problem = small_problem();
  for (const std::uint32_t c : {1U, 3U, 5U}) {
    AdjustedPrior prior;
    prior.camera = c;
    prior.cam_from_world = rotation_from_vector(Vec3(0.02, -0.01, 0.03)) * problem.cameras[c].cam_from_world;
    prior.centre = problem.cameras[c].centre + Vec3(0.1, -0.2, 0.05 * c);
    for (int i = 0; i < 6; ++i) {
      for (int k = 0; k <= i; ++k) prior.px_from_error(i, k) = i == k ? (i < 3 ? 90 : 7) : 1.5 + i - k;
    }
    prior.robust_px = robust_px;
    problem.priors.push_back(prior);
  }
  return problem;
}

TEST(PoseErrorsTest, WithPriorsNoCameraIsHeld) {
  const AdjustmentProblem problem = problem_with_priors(0);
  std::vector<std::size_t> free(6 * problem.cameras.size() + 3 * problem.points.size());
  for (std::size_t u = 0; u < free.size(); ++u) free[u] = u;
  const double sigma_px = sighting_sigma(problem);
  const Dense inverse = inverse_of(normal_of(derivatives_of(problem, sigma_px, free)));
  const std::vector<PoseCovariance> errors = pose_covariances(problem);
  ASSERT_EQ(errors.size(), problem.cameras.size());
  for (std::size_t a = 0; a < 6 * errors.size(); ++a) {
    for (std::size_t b = a - a % 6; b <= a; ++b) {
      const std::size_t row = a % 6, column = b % 6;
      const double scale = std::sqrt(inverse[a][a] * inverse[b][b]);
      EXPECT_NEAR(errors[a / 6][row * (row + 1) / 2 + column], inverse[a][b], 1e-3 * scale);
    }
  }
}

// At the minimum all derivatives vanish. The priors contradict each other, so that none is met.
TEST(AdjustmentTest, PriorsAndSightingsAreInBalance) {
  for (const double robust_px : {0.0, 3.0}) {
    AdjustmentProblem problem = problem_with_priors(robust_px);
    const AdjustmentProblem before = problem;
    AdjustmentParams params{.tolerance = 1e-12};
    ASSERT_TRUE(adjust(problem, params).moved);
    EXPECT_GT((problem.cameras[0].centre - before.cameras[0].centre).norm(), 1e-3) << "no camera is held";
    std::vector<std::size_t> free(6 * problem.cameras.size());
    for (std::size_t u = 0; u < free.size(); ++u) free[u] = u;
    const std::vector<double> residuals = residuals_of(problem, 1);
    const Dense derivatives = derivatives_of(problem, 1, free);
    const std::size_t of_depths = 2 * problem.observations.size(), of_priors = of_depths + problem.depths.size();
    const auto weight = [&](std::size_t first, std::size_t count, double robust) {
      double squares = 0;
      for (std::size_t i = first; i < first + count; ++i) squares += residuals[i] * residuals[i];
      return robust > 0 ? 1 / (1 + squares / (robust * robust)) : 1;
    };
    for (std::size_t u = 0; u < free.size(); ++u) {
      double sum = 0;
      for (std::size_t i = 0; i < residuals.size(); ++i) {
        const double counts = i < of_depths   ? weight(i - i % 2, 2, params.robust_px)
                              : i < of_priors ? 1
                                              : weight(i - (i - of_priors) % 6, 6, robust_px);
        sum += counts * derivatives[u][i] * residuals[i];
      }
      EXPECT_NEAR(sum, 0, 0.02) << "unknown " << u << ", scale " << robust_px;
    }
  }
}

}  // namespace
}  // namespace ilp::model
