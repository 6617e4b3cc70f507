// Fixes on a map as priors of models, over flights that are known exactly but for noise.
#include <gtest/gtest.h>

#include <cstring>

#include "sim/ground/model/map_fixes.hpp"
#include "tests/unit/ground/model/noisy_flight.hpp"

namespace ilp::model {
namespace {

using test::flying_height;
using test::looking_down;
using test::NoisyFlight;
using Mat6 = Eigen::Matrix<double, 6, 6>;
using Vec6 = Eigen::Matrix<double, 6, 1>;

constexpr double tilt_sigma = 0.004, ground_sigma_m = 0.03;

/// The errors of a fix are those of what the optical axis meets and of the attitude: the camera stands wrongly where it
/// is tilted wrongly.
Mat6 fix_root(const Mat3& cam_from_world) {
  Mat6 root = Mat6::Identity();
  root.topLeftCorner<3, 3>() *= tilt_sigma;
  root.bottomRightCorner<3, 3>() *= ground_sigma_m;
  root.bottomLeftCorner<3, 3>() =
      tilt_sigma * flying_height * (cam_from_world.transpose() * cross_matrix(Vec3(0, 0, 1)));
  return root;
}

struct FlightOverMap : NoisyFlight {
  /// A fix of the keyframe on a map whose plane is the world of the truth. `off_m` is an error that nothing states.
  void fix(std::int64_t id, const Similarity& strip_from_truth, const Vec3& off_m = Vec3::Zero()) {
    const RigidTransform& truth = truth_[static_cast<std::size_t>(id - 1)];
    const Mat6 root = fix_root(truth.rotation);
    Vec6 draw;
    for (int k = 0; k < 6; ++k) draw[k] = gauss();
    const Vec6 error = root * draw;
    const Mat3 cam_from_map = rotation_from_vector(-error.head<3>()) * truth.rotation;
    const Vec3 centre = -(truth.rotation.transpose() * truth.translation) - error.tail<3>() + off_m;
    FixRecord fix;
    fix.id = id;
    fix.strip_id = flight_.keyframes.at(id).strip_id;
    fix.map_id = 77;
    fix.state = FixState::accepted;
    fix.verdict = MapVerdict::fixed;
    fix.pixel_m = 0.1;
    fix.body = Body::mars;
    fix.map_longitude_deg = 137.4;
    fix.map_latitude_deg = -4.6;
    fix.map_sigma_m = 20;
    quaternion_from_rotation(cam_from_map, fix.q_cam_from_map);
    const Vec3 axis = cam_from_map.row(2);
    const double distance = -centre.z() / axis.z();
    const Vec3 ground = centre + distance * axis;
    std::copy_n(centre.data(), 3, fix.centre_m);
    std::copy_n(ground.data(), 3, fix.ground_m);
    const Mat6 covariance = root * root.transpose();
    for (int row = 0, k = 0; row < 6; ++row) {
      for (int column = 0; column <= row; ++column, ++k) fix.covariance[k] = covariance(row, column);
    }
    fix.ground_covariance[0] = fix.ground_covariance[2] = ground_sigma_m * ground_sigma_m;
    fix.ground_height_sigma_m = ground_sigma_m;
    fix.ground_depth = distance * strip_from_truth.scale;
    fix.ground_depth_sigma = 0.05 * fix.ground_depth;
    flight_.keyframes.at(id).fix = fix;
  }
  void fly_line(std::int64_t strip, int keyframes, double y, const Similarity& strip_from_truth) {
    std::vector<RigidTransform> poses;
    for (int i = 0; i < keyframes; ++i) poses.push_back(looking_down(2.5 * i, y, 0.1 * std::sin(i)));
    fly(strip, poses, strip_from_truth);
  }
  [[nodiscard]] Vec3 true_centre(std::int64_t id) const {
    const RigidTransform& pose = truth_[static_cast<std::size_t>(id - 1)];
    return -(pose.rotation.transpose() * pose.translation);
  }
  /// How far the camera stands from its true place on the map.
  [[nodiscard]] Vec3 off(std::int64_t id) const {
    return vector_of(flight_.keyframes.at(id).pose->centre) - true_centre(id);
  }
  [[nodiscard]] double rms_off(std::int64_t from, std::int64_t to) const {
    double squares = 0;
    for (std::int64_t id = from; id <= to; ++id) squares += off(id).squaredNorm();
    return std::sqrt(squares / static_cast<double>(to - from + 1));
  }
  /// Normalised error squared of the centre, for each of its coordinates.
  [[nodiscard]] double nes(std::int64_t id) const {
    const PoseRecord& pose = *flight_.keyframes.at(id).pose;
    Mat3 covariance;
    for (int row = 3; row < 6; ++row) {
      for (int column = 3; column <= row; ++column)
        covariance(row - 3, column - 3) = covariance(column - 3, row - 3) =
            pose.covariance[row * (row + 1) / 2 + column];
    }
    return off(id).dot(covariance.inverse() * off(id)) / 3;
  }
  /// Over four keyframes of a flight of 24.
  [[nodiscard]] double mean_nes() const { return (nes(1) + nes(8) + nes(16) + nes(24)) / 4; }
};
constexpr std::uint64_t seeds = 12;

// All images are bent as by a lens that is not known well. The track bends, and no similarity takes that out.
TEST(ModelsOnMap, FixesTakeTheBowOut) {
  constexpr int keyframes = 60;
  FlightOverMap flight;
  flight.radial_px = 0.6;
  flight.fly_line(1, keyframes, 0, flight.second_);
  for (std::int64_t id = 1; id <= keyframes; id += 2) flight.fix(id, flight.second_);
  FlightOverMap images = flight;
  images.link(1, 2);
  for (auto& [id, keyframe] : images.flight_.keyframes) keyframe.fix.reset();
  ASSERT_EQ(images.join().models.size(), 1U);
  const double bow = images.rms_error(images.flight_) * flying_height;
  EXPECT_GT(bow, 0.3) << "otherwise there is nothing to take out";

  const JoinedFlight joined = flight.join();
  ASSERT_EQ(joined.models.size(), 1U);
  ASSERT_TRUE(joined.models[0].on_map.has_value());
  EXPECT_EQ(joined.models[0].on_map->used, keyframes / 2U);
  EXPECT_LT(flight.rms_off(1, keyframes), bow / 8);
  const auto& strip = flight.flight_.strips.at(1);
  ASSERT_TRUE(strip.map.has_value());
  EXPECT_EQ(strip.map->map_id, 77);
  EXPECT_EQ(std::string(intake::unit_of(flight.flight_, strip)), "m");
}

TEST(ModelsOnMap, StatedErrorsAreThoseOfTheTruth) {
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    FlightOverMap flight;
    flight.rng_ = Rng(seed);
    flight.fly_line(1, 24, 0, flight.second_);
    for (std::int64_t id = 1; id <= 24; id += 3) flight.fix(id, flight.second_);
    ASSERT_EQ(flight.join().models.size(), 1U);
    sum += flight.mean_nes();
  }
  EXPECT_GT(sum / seeds, 0.5);
  EXPECT_LT(sum / seeds, 1.6);
}

TEST(ModelsOnMap, StripsWithoutALinkAreOneModel) {
  FlightOverMap flight;
  flight.fly_line(4, 10, 0, Similarity{});
  flight.fly_line(7, 14, 40, flight.second_);
  flight.fly_line(9, 10, 80, flight.second_);
  for (std::int64_t id = 1; id <= 10; ++id) flight.fix(id, Similarity{});
  for (std::int64_t id = 11; id <= 24; ++id) flight.fix(id, flight.second_);
  const PoseRecord apart = *flight.flight_.keyframes.at(30).pose;
  const JoinedFlight joined = flight.join();
  ASSERT_EQ(joined.models.size(), 1U);
  EXPECT_EQ(joined.models[0].strips, (std::vector<std::int64_t>{4, 7}));
  EXPECT_EQ(joined.models[0].strip_id, 4);
  EXPECT_EQ(flight.flight_.strips.at(4).keyframes.size(), 24U);
  EXPECT_TRUE(flight.flight_.strips.at(7).keyframes.empty());
  EXPECT_LT(flight.rms_off(1, 24), 0.05);
  ASSERT_EQ(joined.apart.size(), 1U) << "it has no fix";
  EXPECT_EQ(joined.apart[0].strip_id, 9);
  EXPECT_EQ(std::memcmp(&apart, &*flight.flight_.keyframes.at(30).pose, sizeof(apart)), 0);
}

TEST(ModelsOnMap, OneWrongFixOfTwelveMovesNothing) {
  for (const double off : {1.5, 40.0}) {
    FlightOverMap flight;
    flight.fly_line(1, 24, 0, flight.second_);
    for (std::int64_t id = 1; id <= 24; id += 2) flight.fix(id, flight.second_);
    FlightOverMap wrong = flight;
    wrong.flight_.keyframes.at(9).fix->centre_m[0] += off;
    wrong.flight_.keyframes.at(9).fix->ground_m[0] += off;
    ASSERT_EQ(flight.join().models.size(), 1U);
    const JoinedFlight joined = wrong.join();
    ASSERT_EQ(joined.models.size(), 1U);
    const OnMap& on_map = *joined.models[0].on_map;
    ASSERT_EQ(on_map.fixes.size(), 12U);
    EXPECT_EQ(on_map.used, 11U) << off;
    EXPECT_FALSE(on_map.fixes[4].used) << off;
    for (std::int64_t id = 1; id <= 24; ++id) {
      const PoseRecord& pose = *wrong.flight_.keyframes.at(id).pose;
      const Vec3 moved = vector_of(pose.centre) - vector_of(flight.flight_.keyframes.at(id).pose->centre);
      EXPECT_LT(moved.norm(), std::hypot(pose.sigma[0], pose.sigma[1], pose.sigma[2])) << id << ", off by " << off;
    }
  }
}

// What is stated too small, as over ground whose heights err together, is stated as it is.
TEST(ModelsOnMap, FixesThatErrByMoreThanTheyStateCountLess) {
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    FlightOverMap flight;
    flight.rng_ = Rng(seed);
    flight.fly_line(1, 24, 0, flight.second_);
    for (std::int64_t id = 1; id <= 24; id += 2) flight.fix(id, flight.second_);
    for (auto& [id, keyframe] : flight.flight_.keyframes) {
      if (!keyframe.fix) continue;
      for (double& c : keyframe.fix->covariance) c /= 9;
    }
    const JoinedFlight joined = flight.join();
    ASSERT_EQ(joined.models.size(), 1U);
    EXPECT_NEAR(joined.models[0].on_map->error_factor, 3, 1.2);
    sum += flight.mean_nes();
  }
  EXPECT_LT(sum / seeds, 2);
}

TEST(ModelsOnMap, TwoFixesMoveNothing) {
  FlightOverMap flight;
  flight.fly_line(1, 10, 0, flight.second_);
  flight.fix(2, flight.second_);
  flight.fix(9, flight.second_);
  const intake::Flight before = flight.flight_;
  const JoinedFlight joined = flight.join();
  EXPECT_TRUE(joined.models.empty());
  EXPECT_TRUE(joined.apart.empty());
  for (const auto& [id, keyframe] : flight.flight_.keyframes)
    EXPECT_EQ(std::memcmp(&*keyframe.pose, &*before.keyframes.at(id).pose, sizeof(PoseRecord)), 0);
}

// Fixes of hostile records are none, and do not keep the others from placing the strip.
TEST(ModelsOnMap, FixesWithoutACovarianceAreLeftOut) {
  FlightOverMap flight;
  flight.fly_line(1, 16, 0, flight.second_);
  for (std::int64_t id = 1; id <= 16; ++id) flight.fix(id, flight.second_);
  flight.flight_.keyframes.at(3).fix->covariance[0] = 0;
  flight.flight_.keyframes.at(5).fix->covariance[20] = -1;
  flight.flight_.keyframes.at(7).fix->centre_m[1] = std::nan("");
  flight.flight_.keyframes.at(9).fix->covariance[10] = 1e9;
  flight.flight_.keyframes.at(11).fix->map_id = 78;
  flight.flight_.keyframes.at(13).fix->state = FixState::unconfirmed;
  const JoinedFlight joined = flight.join();
  ASSERT_EQ(joined.models.size(), 1U);
  EXPECT_EQ(joined.models[0].on_map->fixes.size(), 10U);
  EXPECT_LT(flight.rms_off(1, 16), 0.05);
}

// The same number, and other places of its middle: the first of them is not believed more than the others.
TEST(ModelsOnMap, AFixThatPutsTheMapElsewhereDoesNotKeepTheOthersFromIt) {
  for (const FixState state : {FixState::accepted, FixState::unconfirmed}) {
    FlightOverMap flight;
    flight.fly_line(1, 12, 0, flight.second_);
    for (std::int64_t id = 1; id <= 12; ++id) flight.fix(id, flight.second_);
    flight.flight_.keyframes.at(1).fix->state = state;
    flight.flight_.keyframes.at(1).fix->map_longitude_deg = 20;
    const JoinedFlight joined = flight.join();
    ASSERT_EQ(joined.models.size(), 1U);
    ASSERT_TRUE(joined.models[0].on_map);
    EXPECT_EQ(joined.models[0].on_map->fixes.size(), 11U);
    EXPECT_EQ(joined.models[0].on_map->map.longitude_deg, 137.4);
  }
}

}  // namespace
}  // namespace ilp::model
