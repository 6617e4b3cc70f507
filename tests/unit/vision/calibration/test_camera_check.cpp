// Whether windows that were adjusted with a wrong lens are noticed, and right ones left in peace.
#include "fsw/vision/calibration/camera_check.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <memory>

#include "fsw/vision/geometry/camera.hpp"
#include "tests/unit/vision/calibration/posed_window.hpp"

namespace ilp::test {
namespace {

CameraModel lens_of(const CameraModel& ideal) {
  CameraModel out = ideal;
  out.k1 = -0.08;
  out.k2 = 0.01;
  out.p1 = 0.0004;
  out.p2 = -0.0003;
  return out;
}

/// The flight as a camera with another lens would have seen it that is taken for `given`.
void see_through(const CameraModel& lens, const CameraModel& given, SyntheticFlight& flight) {
  for (FlightKeyframe& keyframe : flight.keyframes) {
    for (Corner& corner : keyframe.corners) {
      const Vec2 seen = ideal_from_pixel(given, pixel_from_ideal(lens, Vec2(corner.x, corner.y)));
      corner.x = static_cast<float>(seen.x());
      corner.y = static_cast<float>(seen.y());
    }
  }
}

FlightScene scene_of(unsigned seed) {
  FlightScene scene{.seed = seed, .keyframes = 6, .noise_px = 0.1, .wrong = 0};
  return scene;
}

/// A flight seen through the true lens, and adjusted with one that is off by `error`.
struct WrongFlight {
  SyntheticFlight flight;
  CameraModel given;
  PosedWindow window;

  WrongFlight(const FlightScene& scene, const CameraUnknowns& error)
      : flight(scene), given(corrected(lens_of(flight.camera), error)), window(seen(), given) {}

 private:
  const SyntheticFlight& seen() {
    see_through(lens_of(flight.camera), given, flight);
    return flight;
  }
};

class CameraCheckTest : public ::testing::Test {
 protected:
  void add(WrongFlight& wrong, CameraEvidence& evidence, std::uint32_t steps = ReductionParams{}.steps) {
    EXPECT_TRUE(wrong.window.ok());
    const ReductionParams reduction{.steps = steps};
    IntrinsicsEquations equations;
    EXPECT_TRUE(
        reduce_to_intrinsics(wrong.given, reduction, wrong.window.problem(), *workspace_, equations, evidence.field)
            .ok());
    add_window(equations, evidence);
  }
  CameraModel add(const FlightScene& scene, const CameraUnknowns& error, CameraEvidence& evidence) {
    WrongFlight wrong(scene, error);
    add(wrong, evidence);
    return wrong.given;
  }
  CameraCheck check(const FlightScene& scene, const CameraUnknowns& error) {
    CameraEvidence evidence;
    const CameraModel given = add(scene, error, evidence);
    return judge(evidence, given);
  }

  std::unique_ptr<IntrinsicsWorkspace> workspace_ = std::make_unique<IntrinsicsWorkspace>();
};

TEST_F(CameraCheckTest, ARightCameraIsNeverAccused) {
  for (unsigned seed = 3001; seed <= 3100; ++seed) {
    const CameraCheck said = check(scene_of(seed), {});
    EXPECT_EQ(said.verdict, CameraCheckVerdict::fits) << seed;
    EXPECT_LT(said.statistic, 1.5) << seed;
    for (std::size_t i = 0; i < intrinsic_count; ++i) {
      EXPECT_LT(std::abs(said.corrections[i]), 3 * said.sigmas[i]) << seed << " " << i;
    }
  }
}

TEST_F(CameraCheckTest, AWrongLensIsAlwaysNoticedAndNamed) {
  for (unsigned seed = 3201; seed <= 3230; ++seed) {
    for (const double error : {-0.02, 0.02}) {
      const CameraCheck said = check(scene_of(seed), {0, 0, 0, error, 0, 0, 0});
      EXPECT_EQ(said.verdict, CameraCheckVerdict::contradicts) << seed;
      EXPECT_EQ(said.worst, Intrinsic::k1) << seed;
      EXPECT_NEAR(said.worst_correction, -error, 0.005) << seed;
      EXPECT_NEAR(said.corrections[3], -error, 4 * said.sigmas[3]) << seed;
    }
    const CameraCheck centre = check(scene_of(seed), {0, 16, 0, 0, 0, 0, 0});
    EXPECT_EQ(centre.verdict, CameraCheckVerdict::contradicts) << seed;
    EXPECT_NEAR(centre.corrections[1], -16, 4 * centre.sigmas[1]) << seed;
  }
}

/// What a similarity leaves of the centres, over their spread.
double bend_of(const BundleProblem& window, const SyntheticFlight& flight) {
  const auto views = static_cast<Eigen::Index>(window.cameras.size());
  Eigen::Matrix3Xd found(3, views), truth(3, views);
  for (Eigen::Index i = 0; i < views; ++i) {
    const auto view = static_cast<std::size_t>(i);
    found.col(i) = Eigen::Map<const Vec3>(window.cameras[view].pose.centre);
    truth.col(i) = flight.keyframes[view].truth.centre;
  }
  const Eigen::Matrix4d fit = Eigen::umeyama(found, truth);
  const Eigen::Matrix3Xd left = (fit.topLeftCorner<3, 3>() * found).colwise() + fit.topRightCorner<3, 1>() - truth;
  return left.norm() / (truth.colwise() - truth.rowwise().mean()).norm();
}

TEST_F(CameraCheckTest, TheCostIsHowFarTheWrongLensBendsTheTrack) {
  const CameraUnknowns errors[] = {
      {30}, {0, 16, -10}, {0, 0, 0, 0.03}, {0, 0, 0, 0, 0, 0.002, -0.002}, {-20, 0, 0, -0.05}};
  for (unsigned seed = 3951; seed <= 3956; ++seed) {
    for (const CameraUnknowns& error : errors) {
      FlightScene scene = scene_of(seed);
      scene.noise_px = 0.02;
      WrongFlight wrong(scene, error);
      CameraEvidence evidence;
      add(wrong, evidence, 5);
      const double bend = bend_of(wrong.window.problem(), wrong.flight), cost = judge(evidence, wrong.given).cost;
      EXPECT_NEAR(cost, bend, 0.25 * bend + 2e-5) << seed << " " << error[0] << " " << error[3];
    }
  }
}

TEST_F(CameraCheckTest, EvidenceThatIsNoNumberDoesNotFit) {
  CameraEvidence evidence;
  const CameraModel given = add(scene_of(3961), {}, evidence);
  ASSERT_EQ(judge(evidence, given).verdict, CameraCheckVerdict::fits);
  evidence.information[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(judge(evidence, given).verdict, CameraCheckVerdict::unexplained);
}

TEST_F(CameraCheckTest, WindowsAddUp) {
  CameraEvidence evidence;
  double before = 0;
  for (unsigned window = 0; window < 4; ++window) {
    const CameraModel given = add(scene_of(3301 + window), {0, 0, 0, 0.01, 0, 0, 0}, evidence);
    const CameraCheck said = judge(evidence, given);
    EXPECT_GT(said.statistic, before);
    before = said.statistic;
    EXPECT_LT(said.spread, max_camera_spread);
    EXPECT_EQ(said.verdict,
              said.statistic > max_camera_statistic ? CameraCheckVerdict::contradicts : CameraCheckVerdict::fits);
  }
  EXPECT_GT(before, max_camera_statistic);
}

// A zoom, or what a rolling shutter does: no one lens explains the windows.
TEST_F(CameraCheckTest, WindowsThatAskForDifferentLensesAreUnexplained) {
  CameraEvidence evidence;
  CameraModel given;
  for (unsigned window = 0; window < 4; ++window) {
    given = add(scene_of(3401 + window), {0, 0, 0, window % 2 == 0 ? 0.03 : -0.03, 0, 0, 0}, evidence);
  }
  const CameraCheck said = judge(evidence, given);
  EXPECT_EQ(said.verdict, CameraCheckVerdict::unexplained);
  EXPECT_GT(said.spread, max_camera_spread);
}

// A camera that moves straight over a plane bends it: the images fit any radial distortion.
TEST_F(CameraCheckTest, WhatTheImagesDoNotShowIsNoEvidence) {
  for (unsigned seed = 3501; seed <= 3510; ++seed) {
    FlightScene scene = scene_of(seed);
    scene.world = "flat";
    scene.line = true;
    const CameraCheck said = check(scene, {40, 0, 0, 0, 0, 0, 0});
    EXPECT_EQ(said.verdict, CameraCheckVerdict::fits) << seed;
    EXPECT_GT(said.sigmas[0], 0.5 * usual_errors(lens_of(SyntheticFlight(scene).camera))[0]) << seed;
  }
}

TEST_F(CameraCheckTest, WrongMatchesDoNotMislead) {
  for (unsigned seed = 3601; seed <= 3620; ++seed) {
    FlightScene scene = scene_of(seed);
    scene.wrong = 0.02;
    EXPECT_EQ(check(scene, {}).verdict, CameraCheckVerdict::fits) << seed;
    EXPECT_NE(check(scene, {0, 0, 0, 0.03, 0, 0, 0}).verdict, CameraCheckVerdict::fits) << seed;
  }
}

TEST_F(CameraCheckTest, FewPointsOrCamerasSayNothingAndBadWindowsAreRefused) {
  const SyntheticFlight flight(scene_of(3701));
  const PosedWindow window(flight, flight.camera);
  CameraEvidence evidence;
  EXPECT_EQ(judge(evidence, flight.camera).verdict, CameraCheckVerdict::nothing_seen);
  auto problem = std::make_unique<BundleProblem>(window.problem());
  IntrinsicsEquations equations;
  const auto reduce = [&](const CameraModel& camera) {
    return reduce_to_intrinsics(camera, ReductionParams{}, *problem, *workspace_, equations, evidence.field);
  };
  problem->observations[7].point = static_cast<std::uint16_t>(problem->points.size());
  EXPECT_TRUE(reduce(flight.camera).is(StatusCode::invalid_argument));
  *problem = window.problem();
  problem->observations[9].x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(reduce(flight.camera).is(StatusCode::invalid_argument));
  *problem = window.problem();
  CameraModel bad = flight.camera;
  bad.fx = -1;
  EXPECT_TRUE(reduce(bad).is(StatusCode::invalid_argument));
  for (BundleObservation& o : problem->observations) o.camera = static_cast<std::uint16_t>(o.camera % 2);
  static_cast<void>(problem->cameras.resize(2));
  EXPECT_TRUE(reduce(flight.camera).ok());
  EXPECT_EQ(equations.points, 0U);
  add_window(equations, evidence);
  EXPECT_EQ(evidence.windows, 0U);
}

/// The same equations without any structure: all unknowns in one matrix, derivatives by differences.
class WholeAdjustment {
 public:
  WholeAdjustment(const CameraModel& camera, const BundleProblem& window) : camera_(camera), window_(window) {
    for (const BundleCamera& c : window.cameras) poses_.push_back(cam_from_world(c.pose));
    unknowns_ = static_cast<int>(intrinsic_count + 6 * (poses_.size() - 1) + 3 * window.points.size());
  }
  /// Information and gradient of the intrinsics in these units, with all else eliminated.
  void reduce(const CameraUnknowns& units, Eigen::MatrixXd& information, Eigen::VectorXd& gradient) const {
    const int rows = static_cast<int>(2 * window_.observations.size());
    const Eigen::VectorXd at = residuals(Eigen::VectorXd::Zero(unknowns_));
    Eigen::MatrixXd jacobian(rows, unknowns_);
    constexpr int lens = static_cast<int>(intrinsic_count);
    for (int k = 0; k < unknowns_; ++k) {
      Eigen::VectorXd step = Eigen::VectorXd::Zero(unknowns_);
      step[k] = k < lens ? 1e-5 * units[static_cast<std::size_t>(k)] : 1e-6;
      jacobian.col(k) = (residuals(step) - residuals(-step)) / (2 * step[k]);
      if (k < lens) jacobian.col(k) *= units[static_cast<std::size_t>(k)];
    }
    Eigen::VectorXd squared(rows / 2);
    for (int i = 0; i < rows / 2; ++i) squared[i] = at.segment<2>(2 * i).squaredNorm();
    Eigen::VectorXd sorted = squared;
    std::sort(sorted.begin(), sorted.end());
    const double bound2 = 25 * sorted[rows / 4] / 1.386;
    Eigen::VectorXd weights(rows);
    for (int i = 0; i < rows; ++i) weights[i] = 1 / (1 + squared[i / 2] / bound2);
    const Eigen::MatrixXd normal = jacobian.transpose() * weights.asDiagonal() * jacobian;
    const Eigen::VectorXd right = jacobian.transpose() * weights.asDiagonal() * at;
    const int others = unknowns_ - lens;
    const Eigen::MatrixXd inverse =
        normal.bottomRightCorner(others, others).completeOrthogonalDecomposition().pseudoInverse();
    const Eigen::MatrixXd across = normal.topRightCorner(lens, others);
    information = normal.topLeftCorner(lens, lens) - across * inverse * across.transpose();
    gradient = right.head(lens) - across * inverse * right.tail(others);
  }

 private:
  Eigen::VectorXd residuals(const Eigen::VectorXd& step) const {
    CameraUnknowns corrections{};
    std::copy_n(step.data(), intrinsic_count, corrections.begin());
    const CameraModel camera = corrected(camera_, corrections);
    Eigen::VectorXd out(2 * static_cast<int>(window_.observations.size()));
    int row = 0;
    for (const BundleObservation& o : window_.observations) {
      const int point_at = static_cast<int>(intrinsic_count + 6 * (poses_.size() - 1)) + 3 * o.point;
      const double* x = window_.points[o.point].position;
      Vec3 p = poses_[o.camera] * (Vec3(x[0], x[1], x[2]) + step.segment<3>(point_at));
      if (o.camera > 0) {
        const int pose_at = static_cast<int>(intrinsic_count) + 6 * (o.camera - 1);
        p = rotation_from_vector(step.segment<3>(pose_at)) * p + step.segment<3>(pose_at + 3);
      }
      const Vec2 pixel = pixel_from_normalised(camera, Vec2(p.x() / p.z(), p.y() / p.z()));
      out.segment<2>(row) = pixel - pixel_from_ideal(camera_, Vec2(o.x, o.y));
      row += 2;
    }
    return out;
  }

  const CameraModel& camera_;
  const BundleProblem& window_;
  std::vector<RigidTransform> poses_;
  int unknowns_ = 0;
};

TEST_F(CameraCheckTest, TheReducedEquationsAreThoseOfOneLargeAdjustment) {
  FlightScene scene = scene_of(3801);
  scene.corners = 40;
  SyntheticFlight flight(scene);
  const CameraModel lens = lens_of(flight.camera), given = corrected(lens, {5, 2, -1, 0.01, 0.002, 0.0001, 0});
  see_through(lens, given, flight);
  PosedWindow window(flight, given);
  ASSERT_TRUE(window.ok());
  ASSERT_GT(window.problem().points.size(), 50U);
  IntrinsicsEquations equations;
  ResidualField field;
  ASSERT_TRUE(
      reduce_to_intrinsics(given, ReductionParams{.error_factor = 1}, window.problem(), *workspace_, equations, field)
          .ok());
  const double variance = equations.noise_px * equations.noise_px;
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
  WholeAdjustment(given, window.problem()).reduce(usual_errors(given), information, gradient);
  for (int a = 0; a < static_cast<int>(intrinsic_count); ++a) {
    const auto i = static_cast<std::size_t>(a);
    const double scale = std::sqrt(information(a, a));
    EXPECT_NEAR(equations.gradient[i] * variance / scale, gradient[a] / scale,
                1e-3 * gradient.norm() / information.norm() * scale + 1e-4);
    for (int b = 0; b < static_cast<int>(intrinsic_count); ++b) {
      const double unit = scale * std::sqrt(information(b, b));
      EXPECT_NEAR(equations.information[i][static_cast<std::size_t>(b)] * variance / unit, information(a, b) / unit,
                  1e-4)
          << a << " " << b;
    }
  }
}

}  // namespace
}  // namespace ilp::test
