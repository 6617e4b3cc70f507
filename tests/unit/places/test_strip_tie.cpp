// Ties of strips by links with known errors.
#include "fsw/places/strip_tie.hpp"

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <cmath>
#include <random>

namespace ilp {
namespace {

class StripTieTest : public testing::Test {
 protected:
  StripTieTest() {
    truth_ = {rotation_from_vector(Vec3(0.02, -0.03, 1.1)), Vec3(40, -7, 3), 0.31};
    for (int i = 0; i < 3; ++i) covariance_(i, i) = 1e-6;
    for (int i = 3; i < 6; ++i) covariance_(i, i) = 1e-4;
    covariance_(6, 6) = 1e-6;
    // The steps of one camera: rotation and place go together.
    covariance_(0, 4) = covariance_(4, 0) = 0.8e-5;
  }

  /// A link of which the error is drawn from the covariance, or moved by `wrong` metres.
  LinkedWorld link(std::int64_t keyframe_id, std::int64_t to_strip_id, double wrong = 0) {
    const SimilarityCovariance root = covariance_.llt().matrixL();
    SimilarityStep step;
    for (int i = 0; i < 7; ++i) step(i) = normal_(random_);
    step = root * step;
    step(3) += wrong;
    const Similarity seen = compose(truth_, stepped(step, Similarity{}));
    LinkedWorld linked{.keyframe_id = keyframe_id, .to_strip_id = to_strip_id};
    quaternion_from_rotation(seen.rotation, linked.q_to_from_this);
    for (int i = 0; i < 3; ++i) linked.translation[i] = seen.translation(i);
    linked.scale = seen.scale;
    pack_covariance(covariance_, linked.covariance);
    return linked;
  }
  SimilarityStep error_of(const TieRecord& tie) const {
    return step_between(Similarity{}, compose(inverse(truth_), similarity_of(tie)));
  }

  Similarity truth_;
  SimilarityCovariance covariance_ = SimilarityCovariance::Zero();
  StripLinks links_;
  TieRecord tie_;
  std::mt19937 random_{17};
  std::normal_distribution<double> normal_{0, 1};
};

TEST_F(StripTieTest, LinksOfOneKeyframeDoNotTie) {
  EXPECT_FALSE(tie_strip(links_, tie_));
  add_link(5, link(100, 2), links_);
  add_link(5, link(100, 2), links_);
  EXPECT_FALSE(tie_strip(links_, tie_));
  add_link(5, link(101, 2), links_);
  ASSERT_TRUE(tie_strip(links_, tie_));
  EXPECT_EQ(tie_.id, 5);
  EXPECT_EQ(tie_.to_strip_id, 2);
  EXPECT_EQ(tie_.through_keyframe_id, 101);
  EXPECT_EQ(tie_.links, 3U);
  EXPECT_EQ(tie_.refused, 0U);
}

TEST_F(StripTieTest, TheMeanIsBetterThanOneLinkAndItsErrorHonest) {
  double sum = 0;
  double of_one = 0;
  double of_mean = 0;
  constexpr int trials = 300;
  for (int trial = 0; trial < trials; ++trial) {
    links_ = {};
    for (std::int64_t k = 0; k < 9; ++k) add_link(5, link(100 + k, 2), links_);
    ASSERT_TRUE(tie_strip(links_, tie_));
    const SimilarityStep error = error_of(tie_);
    sum += error.dot(unpack_covariance(tie_.covariance).inverse() * error);
    of_mean += error.segment<3>(3).squaredNorm();
    of_one += 3e-4;
  }
  EXPECT_NEAR(sum / trials, 7, 1.5);
  EXPECT_NEAR(of_mean / of_one, 1.0 / 9, 0.03);
}

// The unit of a strip errs once, however many links lead from it.
TEST_F(StripTieTest, MoreLinksDoNotMakeTheErrorsOfTheUnitsSmaller) {
  constexpr double sigma = 0.01;
  SimilarityCovariance units = SimilarityCovariance::Zero();
  units(6, 6) = sigma * sigma;
  double sum = 0;
  constexpr int trials = 300;
  const Similarity truth = truth_;
  for (int trial = 0; trial < trials; ++trial) {
    links_ = {};
    SimilarityStep of_units = SimilarityStep::Zero();
    of_units(6) = sigma * normal_(random_);
    truth_ = compose(truth, stepped(of_units, Similarity{}));
    for (std::int64_t k = 0; k < 9; ++k) {
      LinkedWorld linked = link(100 + k, 2);
      pack_covariance(covariance_ + units, linked.covariance);
      pack_covariance(units, linked.unit_covariance);
      add_link(5, linked, links_);
    }
    truth_ = truth;
    ASSERT_TRUE(tie_strip(links_, tie_));
    const SimilarityCovariance stated = unpack_covariance(tie_.covariance);
    EXPECT_NEAR(std::sqrt(stated(6, 6)), sigma, 0.05 * sigma);
    const SimilarityStep error = error_of(tie_);
    sum += error.dot(stated.inverse() * error);
  }
  EXPECT_NEAR(sum / trials, 7, 1.5);
}

TEST_F(StripTieTest, AContradictingLinkIsRefused) {
  for (std::int64_t k = 0; k < 5; ++k) add_link(5, link(100 + k, 2), links_);
  add_link(5, link(105, 2, 1.0), links_);
  ASSERT_TRUE(tie_strip(links_, tie_));
  EXPECT_EQ(tie_.links, 5U);
  EXPECT_EQ(tie_.refused, 1U);
  EXPECT_LT(std::fabs(error_of(tie_)(3)), 0.02);
}

TEST_F(StripTieTest, TwoLinksThatContradictEachOtherDoNotTie) {
  add_link(5, link(100, 2), links_);
  add_link(5, link(101, 2, 1.0), links_);
  EXPECT_FALSE(tie_strip(links_, tie_));
}

TEST_F(StripTieTest, TheEarliestStripIsTiedTo) {
  add_link(5, link(100, 4), links_);
  add_link(5, link(101, 4), links_);
  ASSERT_TRUE(tie_strip(links_, tie_));
  EXPECT_EQ(tie_.to_strip_id, 4);
  add_link(5, link(102, 3), links_);
  ASSERT_TRUE(tie_strip(links_, tie_));
  EXPECT_EQ(tie_.to_strip_id, 4) << "one link to strip 3 is not enough";
  add_link(5, link(103, 3), links_);
  ASSERT_TRUE(tie_strip(links_, tie_));
  EXPECT_EQ(tie_.to_strip_id, 3);
}

TEST_F(StripTieTest, LinksOfAnotherStripAreDropped) {
  for (std::int64_t k = 0; k < 5; ++k) add_link(5, link(100 + k, 2), links_);
  add_link(6, link(200, 2), links_);
  EXPECT_FALSE(tie_strip(links_, tie_));
}

TEST_F(StripTieTest, MoreLinksThanThereIsRoomForReplaceTheOldest) {
  for (std::int64_t k = 0; k < 1000; ++k) add_link(5, link(100 + k, 2), links_);
  ASSERT_TRUE(tie_strip(links_, tie_));
  EXPECT_EQ(tie_.through_keyframe_id, 1099);
  EXPECT_LE(tie_.links + tie_.refused, StripLinks::capacity);
}

// A link between cameras whose poses are known leads to the similarity of the worlds.
TEST_F(StripTieTest, ALinkAndTwoPosesGiveTheWorld) {
  PoseRecord newer;
  PoseRecord older;
  newer.state = older.state = PoseState::final;
  const RigidTransform cam_from_newer{rotation_from_vector(Vec3(3, 0.1, 0)), Vec3(1, 2, 30)};
  const RigidTransform cam_from_older{rotation_from_vector(Vec3(0.1, 3, 0)), Vec3(-2, 1, 9)};
  for (auto& [record, transform] : {std::pair<PoseRecord&, const RigidTransform&>(newer, cam_from_newer),
                                    std::pair<PoseRecord&, const RigidTransform&>(older, cam_from_older)}) {
    const Pose pose = pose_from(transform);
    std::copy_n(pose.q_cam_from_world, 4, record.q_cam_from_world);
    std::copy_n(pose.centre, 3, record.centre);
  }
  const Similarity between =
      compose(similarity_from(cam_from_newer), compose(inverse(truth_), inverse(similarity_from(cam_from_older))));
  LinkRecord link{.keyframe_id = 9, .place_strip_id = 2};
  quaternion_from_rotation(between.rotation, link.q_keyframe_from_place);
  for (int i = 0; i < 3; ++i) link.translation[i] = between.translation(i);
  link.scale = between.scale;
  const LinkedWorld world = linked_world(link, newer, older);
  EXPECT_NEAR(world.scale, truth_.scale, 1e-12);
  EXPECT_LT((Vec3(world.translation[0], world.translation[1], world.translation[2]) - truth_.translation).norm(), 1e-9);
  EXPECT_LT((rotation_from_quaternion(world.q_to_from_this) - truth_.rotation).norm(), 1e-9);
}

// A camera 10 units from the first one that errs by 0.1 along the way says that the unit may err by 1 %.
TEST_F(StripTieTest, TheUnitErrsAsTheCameraAlongItsWay) {
  PoseRecord newer, older;
  newer.state = older.state = PoseState::final;
  newer.centre[0] = 10;
  newer.covariance[9] = 0.01;  // of the centre: x, y, z
  newer.covariance[14] = 0.04;
  newer.covariance[20] = 0.04;
  LinkRecord link{.keyframe_id = 9};
  link.q_keyframe_from_place[0] = 1;
  link.scale = 1;
  const auto unit_sigma = [&] {
    return std::sqrt(unpack_covariance(linked_world(link, newer, older).unit_covariance)(6, 6));
  };
  EXPECT_NEAR(unit_sigma(), 0.01, 1e-9);
  newer.ground_distance = 40;
  EXPECT_NEAR(unit_sigma(), 0.1 * 10 / 400, 1e-9) << "a way much shorter than the height tells little";
  newer.centre[0] = 0;
  EXPECT_EQ(unit_sigma(), 0) << "nothing is known at the first camera";
}

}  // namespace
}  // namespace ilp
