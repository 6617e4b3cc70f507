// Ties whose errors are put in by hand.

#include "sim/tools/score/tie_score.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/geometry/similarity.hpp"
#include "tests/unit/tools/score/made_up_strip.hpp"

namespace ilp::score {
namespace {

using test::make_track;

/// Two strips over the same ground. The world of the second one is turned, moved and half as large again.
struct TiedStrips {
  Similarity first_from_second{rotation_from_vector(Vec3(0.3, -0.2, 0.9)), Vec3(1, -2, 0.5), 1.5};
  std::vector<StripScore> strips = std::vector<StripScore>(2);

  TiedStrips() {
    const Similarity second_from_first = inverse(first_from_second);
    for (std::size_t i = 0; i < 2; ++i) {
      strips[i].id = static_cast<std::int64_t>(i) + 1;
      strips[i].track = make_track(20, 20);
    }
    std::int64_t id = 100;
    for (PoseSample& s : strips[1].track.samples) {
      s.keyframe_id = ++id;
      s.centre = second_from_first * s.centre;
      s.cam_from_world = s.cam_from_world * second_from_first.rotation.transpose();
      s.ground_distance = 4;
    }
  }

  /// A tie whose error is `step`, in the second strip's world.
  [[nodiscard]] TieRecord tie(const SimilarityStep& step, const SimilarityCovariance& covariance) const {
    const Similarity tied = compose(first_from_second, inverse(stepped(step, Similarity{})));
    TieRecord tie{.id = 2, .to_strip_id = 1, .through_keyframe_id = 105};
    quaternion_from_rotation(tied.rotation, tie.q_to_from_this);
    for (int k = 0; k < 3; ++k) tie.translation[k] = tied.translation(k);
    tie.scale = tied.scale;
    pack_covariance(covariance, tie.covariance);
    return tie;
  }
};

TieScore score_of(const TieRecord& tie, const std::vector<StripScore>& strips) {
  intake::Flight flight;
  flight.ties.push_back(tie);
  return score_ties(flight, strips);
}

SimilarityStep step_along(int component, double value) {
  SimilarityStep step = SimilarityStep::Zero();
  step(component) = value;
  return step;
}

TEST(TieScore, AnExactTieHasNoError) {
  const TiedStrips flight;
  const TieScore score =
      score_of(flight.tie(SimilarityStep::Zero(), 1e-4 * SimilarityCovariance::Identity()), flight.strips);
  EXPECT_EQ(score.ties, 1U);
  EXPECT_EQ(score.sigmas.within_one, 7U);
  EXPECT_LT(score.sigmas.normalised_error_squared(), 1e-9);
  ASSERT_EQ(score.place_percent.size(), 1U);
  EXPECT_LT(score.place_percent[0], 1e-9);
}

TEST(TieScore, ErrorsCountInTheirStatedSigma) {
  const TiedStrips flight;
  const double sigma = 0.002;
  const SimilarityCovariance covariance = sigma * sigma * SimilarityCovariance::Identity();
  const TieScore moved = score_of(flight.tie(step_along(4, 1.5 * sigma), covariance), flight.strips);
  EXPECT_EQ(moved.sigmas.within_one, 6U);
  EXPECT_EQ(moved.sigmas.within_two, 7U);
  EXPECT_NEAR(moved.sigmas.normalised_error_squared(), 2.25 / 7, 1e-6);
  EXPECT_NEAR(moved.place_percent.at(0), 100 * 1.5 * sigma / 4, 1e-6);
  const TieScore scaled = score_of(flight.tie(step_along(6, 3 * sigma), covariance), flight.strips);
  EXPECT_EQ(scaled.sigmas.within_two, 6U);
  EXPECT_NEAR(scaled.scale_percent.at(0), 0.6, 0.01);
}

TEST(TieScore, CorrelatedErrorsCountTogether) {
  const TiedStrips flight;
  SimilarityCovariance covariance = 1e-4 * SimilarityCovariance::Identity();
  covariance(3, 4) = covariance(4, 3) = 0.99e-4;
  SimilarityStep against = step_along(3, 0.01);
  against(4) = -0.01;
  EXPECT_GT(score_of(flight.tie(against, covariance), flight.strips).sigmas.normalised_error_squared(), 10)
      << "each component is within one sigma, but both against their correlation";
}

TEST(TieScore, OnlyStripsWhoseBeginningTheTruthKnowsAreCompared) {
  TiedStrips flight;
  const TieRecord tie = flight.tie(SimilarityStep::Zero(), SimilarityCovariance::Identity());
  flight.strips[0].track.from_the_start = false;
  EXPECT_EQ(score_of(tie, flight.strips).ties, 0U);
  EXPECT_TRUE(tie_summary(score_of(tie, flight.strips)).empty());
  flight.strips.pop_back();
  EXPECT_EQ(score_of(tie, flight.strips).ties, 0U) << "a strip without a score";
}

}  // namespace
}  // namespace ilp::score
