// The solvers on exact data: the truth is among their answers, and every answer satisfies the equations it stands for.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cstring>
#include <limits>

#include "fsw/vision/twoview/refine/match_error.hpp"
#include "fsw/vision/twoview/robust/model_score.hpp"
#include "fsw/vision/twoview/solvers/decompose_essential.hpp"
#include "fsw/vision/twoview/solvers/eight_point.hpp"
#include "fsw/vision/twoview/solvers/five_point.hpp"
#include "fsw/vision/twoview/solvers/homography.hpp"
#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"
#include "fsw/vision/twoview/solvers/polynomial_roots.hpp"
#include "fsw/vision/twoview/solvers/seven_point.hpp"
#include "fsw/vision/twoview/solvers/singular_values.hpp"
#include "fsw/vision/twoview/solvers/symmetric_eigen.hpp"
#include "tests/unit/vision/twoview/relative_pose_data.hpp"
#include "tests/unit/vision/twoview/synthetic_scene.hpp"

namespace ilp {
namespace {

using test::Motion;
using test::Scene;
using test::SceneOptions;

NormalisedPairs normalised;

Vec3 ray_a(const Scene& scene, std::size_t i) {
  const PointPair& p = scene.pairs[i];
  return {(p.xa - scene.camera_a.cx) / scene.camera_a.fx, (p.ya - scene.camera_a.cy) / scene.camera_a.fy, 1};
}

Vec3 ray_b(const Scene& scene, std::size_t i) {
  const PointPair& p = scene.pairs[i];
  return {(p.xb - scene.camera_b.cx) / scene.camera_b.fx, (p.yb - scene.camera_b.cy) / scene.camera_b.fy, 1};
}

/// Distance of two matrices given up to scale and sign.
double projective_distance(const Mat3& a, const Mat3& b) {
  const Mat3 x = a / a.norm();
  const Mat3 y = b / b.norm();
  return std::min((x - y).norm(), (x + y).norm());
}

/// Share of trials in which the truth is among the answers, to `tolerance`.
double five_point_success(const SceneOptions& base, double tolerance) {
  int found = 0;
  constexpr int trials = 300;
  for (int trial = 0; trial < trials; ++trial) {
    SceneOptions options = base;
    options.matches = 5;
    options.seed = 1000 + static_cast<std::uint64_t>(trial);
    const Scene scene = test::make_scene(options);
    Vec3 a[5];
    Vec3 b[5];
    for (std::size_t i = 0; i < 5; ++i) {
      a[i] = ray_a(scene, i);
      b[i] = ray_b(scene, i);
    }
    Mat3 essentials[max_five_point_solutions];
    const std::size_t count = five_point(a, b, essentials);
    EXPECT_LE(count, max_five_point_solutions);
    const Mat3 truth = essential_from_pose(scene.b_from_a);
    double nearest = 1;
    for (std::size_t k = 0; k < count; ++k) {
      const Mat3& e = essentials[k];
      nearest = std::min(nearest, projective_distance(e, truth));
      EXPECT_NEAR(e.norm(), std::sqrt(2.0), 1e-12);
      for (int i = 0; i < 5; ++i) EXPECT_LT(std::fabs(b[i].dot(e * a[i])), 1e-9);
    }
    if (nearest < tolerance) ++found;
  }
  return static_cast<double>(found) / trials;
}

TEST(FivePoint, FindsTheTruthOnGeneralScenes) {
  EXPECT_GE(five_point_success({}, 1e-6), 0.99);
}

TEST(FivePoint, FindsTheTruthOnPlanes) {
  SceneOptions options{.relief = 0};
  EXPECT_GE(five_point_success(options, 1e-6), 0.98);
}

TEST(FivePoint, FindsTheTruthOnAStraightTrack) {
  // Without rotation several entries of the matrix are zero: a basis of the null space must not divide by them.
  SceneOptions options{.motion = Motion::line};
  EXPECT_GE(five_point_success(options, 1e-6), 0.99);
  options.relief = 0;
  EXPECT_GE(five_point_success(options, 1e-5), 0.98);
}

TEST(FivePoint, FindsTheTruthInForwardMotion) {
  SceneOptions options{.motion = Motion::forward};
  EXPECT_GE(five_point_success(options, 1e-5), 0.98);
}

TEST(FivePoint, AnswersAreEssentialMatrices) {
  SceneOptions options{.matches = 5};
  const Scene scene = test::make_scene(options);
  Vec3 a[5];
  Vec3 b[5];
  for (std::size_t i = 0; i < 5; ++i) {
    a[i] = ray_a(scene, i);
    b[i] = ray_b(scene, i);
  }
  Mat3 essentials[max_five_point_solutions];
  const std::size_t count = five_point(a, b, essentials);
  ASSERT_GT(count, 0U);
  for (std::size_t k = 0; k < count; ++k) {
    const Mat3& e = essentials[k];
    const Mat3 eet = e * e.transpose();
    EXPECT_LT((eet * e - 0.5 * eet.trace() * e).norm(), 1e-7);
    EXPECT_LT(std::fabs(e.determinant()), 1e-7);
  }
}

TEST(FivePoint, RefusesDegenerateAndNonFiniteInput) {
  Vec3 a[5];
  Vec3 b[5];
  for (int i = 0; i < 5; ++i) a[i] = b[i] = Vec3(0.1, 0.2, 1);
  Mat3 essentials[max_five_point_solutions];
  EXPECT_EQ(five_point(a, b, essentials), 0U);
  for (int i = 0; i < 5; ++i) a[i] = Vec3(0.1 * i, std::numeric_limits<double>::quiet_NaN(), 1);
  EXPECT_EQ(five_point(a, b, essentials), 0U);
}

/// Seeds of 200 for which the truth is among the answers.
int seven_point_success(Motion motion) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SceneOptions options{.motion = motion, .matches = 7, .seed = seed};
    const Scene scene = test::make_scene(options);
    Vec3 a[7];
    Vec3 b[7];
    for (std::size_t i = 0; i < 7; ++i) {
      a[i] = ray_a(scene, i);
      b[i] = ray_b(scene, i);
    }
    Mat3 fundamentals[max_seven_point_solutions];
    const std::size_t count = seven_point(a, b, fundamentals);
    double nearest = 1;
    for (std::size_t k = 0; k < count; ++k) {
      nearest = std::min(nearest, projective_distance(fundamentals[k], essential_from_pose(scene.b_from_a)));
      EXPECT_LT(std::fabs(fundamentals[k].determinant()), 1e-9);
      for (int i = 0; i < 7; ++i) EXPECT_LT(std::fabs(b[i].dot(fundamentals[k] * a[i])), 1e-9);
    }
    if (nearest < 1e-6) ++found;
  }
  return found;
}

TEST(SevenPoint, FindsTheTruth) {
  EXPECT_GE(seven_point_success(Motion::sideways), 198);
  EXPECT_GE(seven_point_success(Motion::line), 198);  // most entries of the matrix are zero
  EXPECT_GE(seven_point_success(Motion::forward), 198);
}

TEST(SevenPoint, NothingForMatchesThatDependOnEachOtherOrAreNotFinite) {
  Vec3 a[7];
  Vec3 b[7];
  for (int i = 0; i < 7; ++i) a[i] = b[i] = Vec3(0.1 * (i % 3), 0.2 * (i % 2), 1);
  Mat3 fundamentals[max_seven_point_solutions];
  EXPECT_EQ(seven_point(a, b, fundamentals), 0U);
  for (int i = 0; i < 7; ++i) a[i] = Vec3(0.1 * i, std::numeric_limits<double>::quiet_NaN(), 1);
  EXPECT_EQ(seven_point(a, b, fundamentals), 0U);
}

struct AllIndices {
  explicit AllIndices(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) indices.push_back(static_cast<std::uint16_t>(i));
  }
  [[nodiscard]] PairSelection selection() const { return {indices.data(), indices.size()}; }
  std::vector<std::uint16_t> indices;
};

void normalise_isotropically(const Scene& scene, ImageNormalisation& a, ImageNormalisation& b) {
  isotropic_normalisation(scene.pairs, a, b);
  normalise_pairs(scene.pairs, a, b, 1, normalised);
}

TEST(EightPoint, ExactOnExactData) {
  SceneOptions options{.matches = 20};
  const Scene scene = test::make_scene(options);
  ImageNormalisation a;
  ImageNormalisation b;
  normalise_isotropically(scene, a, b);
  Mat3 f;
  ASSERT_TRUE(eight_point(normalised, AllIndices(20).selection(), f));
  const Mat3 ka = intrinsics_of(scene.camera_a).normalised_from_pixel();
  const Mat3 kb = intrinsics_of(scene.camera_b).normalised_from_pixel();
  const Mat3 truth = kb.transpose() * essential_from_pose(scene.b_from_a) * ka;
  const Mat3 pixels = b.normalised_from_pixel().transpose() * f * a.normalised_from_pixel();
  EXPECT_LT(projective_distance(pixels, truth), 1e-8);
  EXPECT_FALSE(eight_point(normalised, AllIndices(7).selection(), f));
}

TEST(EightPoint, RefusesAPlane) {
  SceneOptions options{.relief = 0};
  const Scene scene = test::make_scene(options);
  ImageNormalisation a;
  ImageNormalisation b;
  normalise_isotropically(scene, a, b);
  Mat3 f;
  EXPECT_FALSE(eight_point(normalised, AllIndices(normalised.size()).selection(), f));
}

/// The map of the plane z = d of frame a, in rays.
Mat3 plane_homography(const Scene& scene, double depth) {
  return scene.b_from_a.rotation + scene.b_from_a.translation * Vec3(0, 0, 1).transpose() / depth;
}

TEST(Homography, IsExactOnAPlane) {
  SceneOptions options{.relief = 0, .matches = 40};
  const Scene scene = test::make_scene(options);
  normalise_pairs(scene.pairs, intrinsics_of(scene.camera_a), intrinsics_of(scene.camera_b), 1, normalised);
  const Mat3 truth = plane_homography(scene, 1 / options.baseline);
  int solved = 0;
  for (std::uint16_t first = 0; first + 4 <= 40; first = static_cast<std::uint16_t>(first + 4)) {
    const std::uint16_t sample[4] = {first, static_cast<std::uint16_t>(first + 1),
                                     static_cast<std::uint16_t>(first + 2), static_cast<std::uint16_t>(first + 3)};
    Mat3 h;
    if (!homography_from_four(normalised, sample, h)) continue;
    ++solved;
    EXPECT_LT(projective_distance(h, truth), 1e-7);
  }
  EXPECT_GE(solved, 9);
  for (const NormalisedPair& pair : normalised.exact) {
    EXPECT_LT(transfer_squared(truth, pair, normalised.scale), 1e-10);
    EXPECT_LT(homography_sampson_squared(truth, pair, normalised.scale), 1e-10);
  }
}

TEST(Homography, RefusesThreePointsOnALine) {
  PointPairs pairs;
  for (int i = 0; i < 4; ++i) {
    static_cast<void>(pairs.push_back({10.0 * i, i == 3 ? 50.0 : 20.0 * i, 10.0 * i + 5, i == 3 ? 55.0 : 20.0 * i, 0}));
  }
  normalise_pairs(pairs, {100, 100, 0, 0}, {100, 100, 0, 0}, 1, normalised);
  const std::uint16_t sample[4] = {0, 1, 2, 3};
  Mat3 h;
  EXPECT_FALSE(homography_from_four(normalised, sample, h));
}

TEST(Homography, SampsonIsHalfTheTransferErrorOfAShift) {
  // For a pure shift both images share an error equally: the nearest exact match is half-way.
  PointPairs pairs;
  static_cast<void>(pairs.push_back({100, 100, 112, 100, 0}));
  normalise_pairs(pairs, {100, 100, 0, 0}, {100, 100, 0, 0}, 1, normalised);
  Mat3 shift = Mat3::Identity();
  shift(0, 2) = 0.1;  // 10 px
  EXPECT_NEAR(transfer_squared(shift, normalised.exact[0], normalised.scale), 4, 1e-9);
  EXPECT_NEAR(homography_sampson_squared(shift, normalised.exact[0], normalised.scale), 2, 1e-9);
}

TEST(Homography, DecompositionContainsTheMotion) {
  for (const Motion kind : {Motion::sideways, Motion::line, Motion::forward}) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      SceneOptions options{.motion = kind, .matches = 1, .seed = seed};
      const Scene scene = test::make_scene(options);
      PlaneMotion motions[4];
      ASSERT_EQ(decompose_homography(-3 * plane_homography(scene, 5), motions), 4U);
      double nearest = 10;
      for (const PlaneMotion& motion : motions) {
        const RigidTransform& pose = motion.b_from_a;
        const Mat3 rebuilt = pose.rotation + pose.translation * motion.plane.transpose();
        EXPECT_LT(projective_distance(rebuilt, plane_homography(scene, 5)), 1e-7);
        EXPECT_LT((pose.rotation * pose.rotation.transpose() - Mat3::Identity()).norm(), 1e-9);
        nearest = std::min(nearest, (pose.rotation - scene.b_from_a.rotation).norm() +
                                        (pose.translation - scene.b_from_a.translation).norm() +
                                        (motion.plane - Vec3(0, 0, 0.2)).norm());
      }
      EXPECT_LT(nearest, 1e-6);
    }
  }
  PlaneMotion motions[4];
  EXPECT_EQ(decompose_homography(rotation_from_vector(Vec3(0.1, 0.2, 0.3)), motions), 0U);
}

TEST(DecomposeEssential, FourPosesOneOfWhichSeesThePoints) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    SceneOptions options{.matches = 10, .seed = seed};
    const Scene scene = test::make_scene(options);
    RigidTransform poses[4];
    ASSERT_TRUE(decompose_essential(-2.5 * essential_from_pose(scene.b_from_a), poses));
    int seen_by = 0;
    for (const RigidTransform& pose : poses) {
      EXPECT_NEAR(pose.rotation.determinant(), 1, 1e-12);
      EXPECT_LT(projective_distance(essential_from_pose(pose), essential_from_pose(scene.b_from_a)), 1e-9);
      bool sees_all = true;
      for (std::size_t i = 0; i < 10; ++i) sees_all &= meets_in_front(pose, ray_a(scene, i), ray_b(scene, i), 1e-6);
      if (!sees_all) continue;
      ++seen_by;
      EXPECT_LT((pose.rotation - scene.b_from_a.rotation).norm(), 1e-9);
      EXPECT_LT((pose.translation - scene.b_from_a.translation).norm(), 1e-9);
    }
    EXPECT_EQ(seen_by, 1);
  }
  RigidTransform poses[4];
  EXPECT_FALSE(decompose_essential(Mat3::Zero(), poses));
  EXPECT_FALSE(decompose_essential(Mat3::Constant(std::numeric_limits<double>::quiet_NaN()), poses));
}

TEST(ScorePose, CountsOnlyWhatBothCamerasSee) {
  const Scene scene = test::make_scene({});
  normalise_pairs(scene.pairs, intrinsics_of(scene.camera_a), intrinsics_of(scene.camera_b), 1, normalised);
  RigidTransform poses[4];
  ASSERT_TRUE(decompose_essential(essential_from_pose(scene.b_from_a), poses));
  for (const RigidTransform& pose : poses) {
    RansacScore score;
    ASSERT_TRUE(score_epipolar(normalised, essential_from_pose(pose), 1, {}, score));
    EXPECT_EQ(score.inliers, 300U);
    ASSERT_TRUE(score_pose(normalised, pose, 1, {}, score));
    // One of the four poses sees the points; in the others they lie behind a, behind b, or behind both.
    const bool right = (pose.rotation - scene.b_from_a.rotation).norm() < 1e-6 &&
                       (pose.translation - scene.b_from_a.translation).norm() < 1e-6;
    EXPECT_EQ(score.inliers, right ? 300U : 0U);
    EXPECT_NEAR(score.cost, right ? 0 : 300, 1e-3);
    EXPECT_EQ(score_pose(normalised, pose, 1, {100}, score), right);  // early bail-out
  }
}

TEST(SingularValues, RebuildsTheMatrix) {
  Mat3 m;
  m << 2, -1, 0.5, 0.25, 3, 1, -1, 0.75, -2;
  SingularValues svd;
  ASSERT_TRUE(singular_values(m, svd));
  EXPECT_LT((svd.u * svd.values.asDiagonal() * svd.v.transpose() - m).norm(), 1e-12);
  EXPECT_NEAR(svd.u.determinant(), 1, 1e-12);
  EXPECT_NEAR(svd.v.determinant(), 1, 1e-12);
  EXPECT_LT(m.determinant(), 0);
  EXPECT_LT(svd.values[2], 0);
}

TEST(SymmetricEigen, DecomposesAndOrders) {
  Rng rng(8);
  for (int trial = 0; trial < 50; ++trial) {
    Eigen::Matrix<double, 9, 9> half;
    for (int i = 0; i < 81; ++i) half(i / 9, i % 9) = test::symmetric(rng, 1);
    if (trial == 0) half.row(3).setZero();
    const Eigen::Matrix<double, 9, 9> m = half * half.transpose();
    SymmetricEigen<9> eigen;
    ASSERT_TRUE(symmetric_eigen(m, eigen));
    EXPECT_LT((m * eigen.vectors - eigen.vectors * eigen.values.asDiagonal()).norm(), 1e-13 * m.norm());
    EXPECT_LT((eigen.vectors.transpose() * eigen.vectors - Eigen::Matrix<double, 9, 9>::Identity()).norm(), 1e-13);
    for (int i = 0; i < 8; ++i) EXPECT_LE(eigen.values[i], eigen.values[i + 1]);
    EXPECT_NEAR(eigen.values.sum(), m.trace(), 1e-12 * m.trace());
  }
  SymmetricEigen<3> eigen;
  Mat3 bad = Mat3::Identity();
  bad(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(symmetric_eigen(bad, eigen));
  ASSERT_TRUE(symmetric_eigen<3>(Mat3::Zero(), eigen));
  EXPECT_EQ(eigen.values, Vec3(0, 0, 0));
}

TEST(RealRoots, FindsWhatTheProductWasMadeOf) {
  // (x + 3)(x + 0.5)(x - 0.001)(x - 2)(x - 1000)(x^2 + 1)
  double c[8] = {1};
  int degree = 0;
  for (const double root : {-3.0, -0.5, 0.001, 2.0, 1000.0}) {
    for (int k = ++degree; k >= 0; --k) c[k] = (k > 0 ? c[k - 1] : 0) - root * (k < degree ? c[k] : 0);
  }
  for (int k = 7; k >= 2; --k) c[k] += c[k - 2];
  RealRoots<7> solver;
  double roots[7];
  ASSERT_EQ(solver.find(c, roots), 5);
  const double expected[5] = {-3, -0.5, 0.001, 2, 1000};
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(roots[i], expected[i], 1e-9 * std::max(1.0, std::fabs(expected[i])));
}

TEST(RealRoots, NoneForPositiveZeroAndNonFinitePolynomials) {
  RealRoots<2> solver;
  double roots[2];
  const double positive[3] = {1, 0, 1};
  const double zero[3] = {0, 0, 0};
  const double bad[3] = {1, std::numeric_limits<double>::quiet_NaN(), 1};
  const double infinite[3] = {1, 1, std::numeric_limits<double>::infinity()};
  EXPECT_EQ(solver.find(positive, roots), 0);
  EXPECT_EQ(solver.find(zero, roots), 0);
  EXPECT_EQ(solver.find(bad, roots), 0);
  EXPECT_EQ(solver.find(infinite, roots), 0);
}

TEST(RealRoots, LowerDegreeAndDoubleRoot) {
  RealRoots<4> solver;
  double roots[4];
  const double line[5] = {-6, 3, 0, 0, 0};
  ASSERT_EQ(solver.find(line, roots), 1);
  EXPECT_NEAR(roots[0], 2, 1e-12);
  const double square[5] = {4, -4, 1, 0, 0};  // (x - 2)^2
  const int count = solver.find(square, roots);
  ASSERT_EQ(count, 1);
  EXPECT_NEAR(roots[0], 2, 1e-6);
}

}  // namespace
}  // namespace ilp
