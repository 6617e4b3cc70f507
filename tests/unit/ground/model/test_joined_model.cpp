// Joins strips of which everything is known (noisy_flight.hpp).

#include "sim/ground/model/joined_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "tests/unit/ground/model/noisy_flight.hpp"

namespace ilp::model {
namespace {

using test::flying_height, test::ground, test::looking_down, test::NoisyFlight;

class JoinedModelTest : public ::testing::Test, protected NoisyFlight {};

TEST_F(JoinedModelTest, TwoLanesStandInTheWorldOfTheFirst) {
  fly_two_lanes();
  link(5, 6);
  link(4, 7);
  link(1, 10);
  const JoinedFlight joined = join();
  ASSERT_EQ(joined.models.size(), 1U);
  EXPECT_EQ(joined.models[0].members.size(), 10U);
  EXPECT_EQ(joined.models[0].strip_id, 1);
  EXPECT_TRUE(joined.apart.empty());
  EXPECT_FALSE(joined.models[0].by_ties);
  EXPECT_LT(joined.models[0].median_error_px, 0.12);
  EXPECT_LT(position_error(Similarity{}, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10}), 0.001);
  EXPECT_EQ(flight_.strips[1].keyframes.size(), 10U);
  EXPECT_TRUE(flight_.strips[2].keyframes.empty());
  for (std::int64_t id = 6; id <= 10; ++id) {
    const intake::Keyframe& keyframe = flight_.keyframes[id];
    EXPECT_EQ(keyframe.strip_id, 1);
    EXPECT_NEAR(keyframe.depth_scale * second_.scale, 1, 0.001) << "depths are in the unit of the first strip";
    for (const intake::StructureTrackPoint& track : keyframe.points) {
      const double(&p)[3] = track.point.position;
      EXPECT_NEAR(p[2], ground(p[0], p[1]), 0.01 * flying_height) << "points move with their keyframe";
    }
  }
  for (const ClosedLink& closed : joined.models[0].links) {
    EXPECT_GE(closed.points, 12U);
    EXPECT_LT(closed.after_px, 0.3);
  }
}

TEST_F(JoinedModelTest, WithoutLinksNothingChanges) {
  fly_two_lanes();
  std::vector<PoseRecord> before;
  for (const auto& [id, keyframe] : flight_.keyframes) before.push_back(*keyframe.pose);
  const JoinedFlight joined = join();
  EXPECT_TRUE(joined.models.empty());
  EXPECT_TRUE(joined.apart.empty());
  for (const PoseRecord& pose : before)
    EXPECT_EQ(std::memcmp(&pose, &*flight_.keyframes[pose.id].pose, sizeof(PoseRecord)), 0);
}

TEST_F(JoinedModelTest, PointsThatContradictEachOtherJoinNothing) {
  fly_two_lanes();
  link(5, 6, true, 60);
  link(4, 7, true, 60);
  const JoinedFlight joined = join();
  EXPECT_TRUE(joined.models.empty());
  EXPECT_LT(position_error(second_, {6, 7, 8, 9, 10}), 1e-6) << "the second strip stays where it was";
  ASSERT_EQ(joined.apart.size(), 2U);
  EXPECT_FALSE(joined.apart[0].why.empty());
}

TEST_F(JoinedModelTest, AKeyframeWithoutAPoseGetsOne) {
  fly_two_lanes();
  see_without_pose(11, looking_down(5, -2.5, 1));
  link(2, 11);
  link(3, 11);
  link(5, 6);
  const JoinedFlight joined = join();
  ASSERT_EQ(joined.models.size(), 1U);
  EXPECT_EQ(joined.models[0].members.size(), 11U);
  EXPECT_FALSE(joined.models[0].members.back().posed_by_flight);
  ASSERT_TRUE(flight_.keyframes[11].posed());
  EXPECT_LT(position_error(Similarity{}, {11}), 0.002);
}

// Its points with the other keyframe do not tell how far apart the two are, but the depths there do.
TEST_F(JoinedModelTest, AKeyframeThatSharesPointsWithOneOtherOnlyIsAttachedToIt) {
  fly_two_lanes();
  see_without_pose(11, looking_down(5, -2.5, 1));
  link(2, 11);
  link(5, 6);
  const JoinedFlight joined = join();
  ASSERT_EQ(joined.models.size(), 1U);
  ASSERT_EQ(joined.models[0].members.size(), 11U);
  EXPECT_EQ(joined.models[0].members.back().attached_to, 2);
  EXPECT_EQ(joined.models[0].members.front().attached_to, 0);
  ASSERT_TRUE(flight_.keyframes[11].posed());
  EXPECT_LT(position_error(Similarity{}, {11}), 0.01);
  EXPECT_TRUE(joined.apart.empty());
}

TEST_F(JoinedModelTest, AKeyframeWhosePointsFitNoPlaceStaysApart) {
  fly_two_lanes();
  see_without_pose(11, looking_down(5, -2.5, 1));
  link(2, 11, true, 60);
  link(5, 6);
  const JoinedFlight joined = join();
  ASSERT_EQ(joined.models.size(), 1U);
  EXPECT_EQ(joined.models[0].members.size(), 10U);
  EXPECT_FALSE(flight_.keyframes[11].posed());
  ASSERT_EQ(joined.apart.size(), 1U);
  EXPECT_FALSE(joined.apart[0].why.empty());
}

TEST_F(JoinedModelTest, WhereNoPointsCameDownTheTiePlacesTheStrip) {
  fly_two_lanes();
  link(5, 6, false);
  TieRecord tie{.id = 2, .to_strip_id = 1};
  const Similarity to_from_this = inverse(second_);
  quaternion_from_rotation(to_from_this.rotation, tie.q_to_from_this);
  std::copy_n(to_from_this.translation.data(), 3, tie.translation);
  tie.scale = to_from_this.scale;
  flight_.ties.push_back(tie);
  const JoinedFlight joined = join();
  ASSERT_EQ(joined.models.size(), 1U);
  EXPECT_TRUE(joined.models[0].by_ties);
  EXPECT_LT(position_error(Similarity{}, {6, 7, 8, 9, 10}), 1e-3);
}

TEST_F(JoinedModelTest, ATieThatIsNoSimilarityPlacesNothing) {
  fly_two_lanes();
  link(5, 6, false);
  for (const double broken : {0.0, std::nan(""), 7.0}) {
    TieRecord tie{.id = 2, .to_strip_id = 1};
    tie.q_to_from_this[0] = broken;
    flight_.ties = {tie};
    EXPECT_TRUE(join().models.empty()) << broken;
  }
  // Their squares and products are no numbers any more.
  for (const double absurd : {5e-324, 1e-300, 1e300, std::numeric_limits<double>::infinity(), -1.0, std::nan("")}) {
    TieRecord tie{.id = 2, .to_strip_id = 1, .scale = absurd};
    flight_.ties = {tie};
    EXPECT_TRUE(join().models.empty()) << absurd;
  }
  for (const double absurd : {1e300, -1e200, std::nan("")}) {
    TieRecord tie{.id = 2, .to_strip_id = 1};
    tie.translation[1] = absurd;
    flight_.ties = {tie};
    EXPECT_TRUE(join().models.empty()) << absurd;
  }
}

TEST_F(JoinedModelTest, ALoopIsClosedWhereTheStripHasDrifted) {
  // Twice round a circle; the poses of the flight creep in scale and heading.
  constexpr int count = 24;
  std::vector<RigidTransform> circle;
  for (int i = 0; i < count; ++i) {
    const double angle = 4 * 3.14159265 * i / count;
    circle.push_back(looking_down(6 * std::cos(angle), 6 * std::sin(angle), angle));
  }
  fly(1, circle, Similarity{});
  drift([](std::int64_t id) {
    const double creep = 0.004 * static_cast<double>(id - 1);
    return Similarity{rotation_from_vector(Vec3(0, 0, 0.3 * creep)), Vec3::Zero(), 1 + creep};
  });
  const double before = position_error(Similarity{}, {24});
  for (std::int64_t id = 13; id <= 24; ++id) link(id - 12, id);
  const JoinedFlight joined = join();
  ASSERT_EQ(joined.models.size(), 1U);
  ASSERT_GT(before, 0.03);
  // The world of the strip is where its drifted cameras are on average; what counts is its shape.
  double spread = 0;
  for (std::int64_t id = 13; id <= 24; ++id) {
    const double(&a)[3] = flight_.keyframes[id - 12].pose->centre;
    const double(&b)[3] = flight_.keyframes[id].pose->centre;
    spread = std::max(spread, (Vec3(a[0], a[1], a[2]) - Vec3(b[0], b[1], b[2])).norm() / flying_height);
  }
  EXPECT_LT(spread, before / 10) << "after a round the camera is where it was";
}

/// Errors of the positions in a joined flight of one world, each in units of its estimated error, in the gauge in which
/// these are stated: the first camera, and one coordinate of the farthest one. Empty where there is no such gauge.
std::vector<double> normalised_errors(NoisyFlight& flight) {
  const auto count = static_cast<std::int64_t>(flight.truth_.size());
  const auto pose_of_model = [&](std::int64_t id) {
    return cam_from_world(pose_of(*flight.flight_.keyframes[id].pose));
  };
  const auto truth = [&](std::int64_t id) { return flight.truth_[static_cast<std::size_t>(id - 1)]; };
  const RigidTransform first = pose_of_model(1), true_first = truth(1);
  const auto in_world = [&](const RigidTransform& reference, const RigidTransform& pose) {
    const Vec3 from_first = reference * Vec3(-(pose.rotation.transpose() * pose.translation));
    return Vec3(first.rotation.transpose() * from_first);
  };
  std::int64_t anchor = 0;
  double scale = 0;
  for (std::int64_t id = 2; id <= count; ++id) {
    for (int k = 0; k < 3; ++k) {
      if (flight.flight_.keyframes[id].pose->sigma[k] > 0) continue;
      if (anchor != 0) return {};
      anchor = id;
      scale = in_world(true_first, truth(id))[k] / in_world(first, pose_of_model(id))[k];
    }
  }
  std::vector<double> errors;
  for (std::int64_t id = 2; id <= count && anchor != 0; ++id) {
    const Vec3 error = scale * in_world(first, pose_of_model(id)) - in_world(true_first, truth(id));
    for (int k = 0; id != anchor && k < 3; ++k)
      errors.push_back(error[k] / flight.flight_.keyframes[id].pose->sigma[k]);
  }
  return errors;
}

struct ErrorStatistics {
  double mean_square = 0, within_two = 0;

  explicit ErrorStatistics(const std::vector<double>& errors) {
    for (const double error : errors) {
      mean_square += error * error / static_cast<double>(errors.size());
      within_two += (std::fabs(error) < 2 ? 1.0 : 0.0) / static_cast<double>(errors.size());
    }
  }
};

/// Of two lanes that three links join.
std::vector<double> errors_of_linked_lanes(std::uint64_t seed, NoisyFlight& flight) {
  flight.rng_ = Rng(seed);
  flight.fly_two_lanes();
  flight.link(5, 6);
  flight.link(4, 7);
  flight.link(1, 10);
  EXPECT_EQ(flight.join().models.size(), 1U);
  return normalised_errors(flight);
}

/// Of lanes of 25 keyframes, so many keyframes that they are adjusted in sub-maps.
std::vector<double> errors_of_many_keyframes(std::uint64_t seed, int lanes, NoisyFlight& flight) {
  flight.rng_ = Rng(seed);
  flight.fly_lanes(lanes, 25);
  EXPECT_EQ(flight.join().models.size(), 1U);
  const std::vector<double> errors = normalised_errors(flight);
  EXPECT_EQ(errors.size(), 3 * (25 * static_cast<std::size_t>(lanes) - 2));
  return errors;
}

/// Of flights whose images are bent, in each flight in another way.
template <typename ErrorsOf>
ErrorStatistics statistics_of_bent_flights(std::uint64_t seeds, ErrorsOf errors_of) {
  std::vector<double> errors;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    NoisyFlight flight{.bend_px = 0.14, .bend_phase = 0.9 * static_cast<double>(seed)};
    const std::vector<double> of_flight = errors_of(seed, flight);
    errors.insert(errors.end(), of_flight.begin(), of_flight.end());
  }
  return ErrorStatistics(errors);
}

TEST(JoinedModelErrors, AgreeWithTheTrueOnes) {
  std::vector<double> errors;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    NoisyFlight flight;
    const std::vector<double> of_flight = errors_of_linked_lanes(seed, flight);
    ASSERT_EQ(of_flight.size(), 3 * 8U) << "one coordinate holds the scale";
    errors.insert(errors.end(), of_flight.begin(), of_flight.end());
  }
  const ErrorStatistics statistics(errors);
  EXPECT_NEAR(statistics.mean_square, 1, 0.5);
  EXPECT_GT(statistics.within_two, 0.88);
}

// Sightings in one place err together there, and many of them tell no more than few.
TEST(JoinedModelErrors, OfBentImagesAreStated) {
  const ErrorStatistics statistics = statistics_of_bent_flights(12, errors_of_linked_lanes);
  EXPECT_LT(statistics.mean_square, 2);
  EXPECT_GT(statistics.mean_square, 0.3) << "no error is stated that says nothing";
}

// Errors of neighbours are nearly the same, so that one flight tells little.
TEST(JoinedModelErrors, OfManyKeyframesAgreeWithTheTrueOnes) {
  std::vector<double> errors;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    NoisyFlight flight;
    const std::vector<double> of_flight = errors_of_many_keyframes(seed, 18, flight);
    errors.insert(errors.end(), of_flight.begin(), of_flight.end());
  }
  const ErrorStatistics statistics(errors);
  EXPECT_NEAR(statistics.mean_square, 1, 0.5);
  EXPECT_GT(statistics.within_two, 0.88);
}

// Without what sightings have in common, the mean square is 2.06, and with it 0.50.
TEST(JoinedModelErrors, OfBentImagesAreStatedInSubMaps) {
  const ErrorStatistics statistics = statistics_of_bent_flights(
      6, [](std::uint64_t seed, NoisyFlight& flight) { return errors_of_many_keyframes(seed, 12, flight); });
  EXPECT_LT(statistics.mean_square, 1.5);
  EXPECT_GT(statistics.mean_square, 0.3) << "no error is stated that says nothing";
}

// The ground that it shares with the end of the lane lies outside all other images, and is not as flat as the plane
// that continues the depths there.
TEST(JoinedModelErrors, OfAKeyframeAttachedToOneOtherAreStated) {
  constexpr int flights = 12;
  int within_one = 0, within_three = 0;
  double stated = 0, measured = 0;
  for (int i = 0; i < flights; ++i) {
    NoisyFlight flight{.rng_ = Rng(static_cast<std::uint64_t>(i + 1))};
    flight.fly_two_lanes();
    const double along = -2.5 - 0.1 * i;
    flight.see_without_pose(11, looking_down(along, 0.3 * (i % 5), 0.5 * i));
    flight.link(1, 11);
    flight.link(5, 6);
    flight.link(4, 7);
    const JoinedFlight joined = flight.join();
    ASSERT_EQ(joined.models.size(), 1U);
    ASSERT_EQ(joined.models[0].members.size(), 11U) << i;
    ASSERT_EQ(joined.models[0].members.back().attached_to, 1);
    const PoseRecord& pose = *flight.flight_.keyframes[11].pose;
    const double sigma = std::hypot(pose.sigma[0], pose.sigma[1], pose.sigma[2]),
                 error = flying_height * flight.position_error(Similarity{}, {11});
    within_one += error < sigma ? 1 : 0;
    within_three += error < 3 * sigma ? 1 : 0;
    stated += sigma / flights;
    measured += error / flights;
  }
  EXPECT_GE(within_one, flights / 2);
  EXPECT_EQ(within_three, flights);
  EXPECT_LT(stated, 6 * measured) << "and no error is stated that says nothing";
  EXPECT_LT(measured, 0.03 * flying_height);
}

TEST_F(JoinedModelTest, TheSameFlightGivesTheSameBytes) {
  fly_two_lanes();
  link(5, 6);
  link(4, 7);
  intake::Flight again = flight_;
  (void)join();
  (void)join_strips(again, [](const std::string&) {});
  for (const auto& [id, keyframe] : flight_.keyframes)
    EXPECT_EQ(std::memcmp(&*keyframe.pose, &*again.keyframes.at(id).pose, sizeof(PoseRecord)), 0);
}

}  // namespace
}  // namespace ilp::model
