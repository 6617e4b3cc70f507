// Similarities as algebra, and steps of them to first order.
#include "fsw/vision/geometry/similarity.hpp"

#include <gtest/gtest.h>

#include <random>

namespace ilp {
namespace {

class SimilarityTest : public testing::Test {
 protected:
  Vec3 any(double size) { return size * Vec3(uniform_(random_), uniform_(random_), uniform_(random_)); }
  Similarity any_similarity() { return {rotation_from_vector(any(2)), any(10), 1.5 + uniform_(random_)}; }
  SimilarityStep any_step(double size) {
    SimilarityStep step;
    for (int i = 0; i < 7; ++i) step(i) = size * uniform_(random_);
    return step;
  }

 private:
  std::mt19937 random_{5};
  std::uniform_real_distribution<double> uniform_{-1, 1};
};

TEST_F(SimilarityTest, CompositionAndInverseActOnPointsInTurn) {
  for (int trial = 0; trial < 100; ++trial) {
    const Similarity a = any_similarity();
    const Similarity b = any_similarity();
    const Vec3 x = any(20);
    EXPECT_LT((compose(b, a) * x - b * (a * x)).norm(), 1e-11);
    EXPECT_LT((inverse(a) * (a * x) - x).norm(), 1e-11);
  }
}

TEST_F(SimilarityTest, AStepBetweenTwoLeadsFromTheOneToTheOther) {
  for (int trial = 0; trial < 100; ++trial) {
    const Similarity from = any_similarity();
    const Similarity to = any_similarity();
    const Similarity reached = stepped(step_between(from, to), from);
    const Vec3 x = any(20);
    EXPECT_LT((reached * x - to * x).norm(), 1e-9);
  }
}

TEST_F(SimilarityTest, AStepInTheOtherFrameIsTheSameChange) {
  constexpr double small = 1e-6;
  for (int trial = 0; trial < 100; ++trial) {
    const Similarity b_from_a = any_similarity();
    const SimilarityStep step = any_step(small);
    const Vec3 x = any(20);
    const Vec3 before = b_from_a * (stepped(step, Similarity{}) * x);
    const Vec3 after = stepped(step_in_other_frame(b_from_a) * step, b_from_a) * x;
    // What is left is of second order.
    EXPECT_LT((before - after).norm(), 1e3 * small * small);
  }
}

TEST_F(SimilarityTest, APackedCovarianceComesBack) {
  SimilarityCovariance covariance;
  for (int row = 0; row < 7; ++row) {
    for (int column = 0; column < 7; ++column) covariance(row, column) = 1 + row * column + row + column;
  }
  double lower[similarity_covariance_elements];
  pack_covariance(covariance, lower);
  EXPECT_EQ(unpack_covariance(lower), covariance);
}

}  // namespace
}  // namespace ilp
