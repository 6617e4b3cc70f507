#include <gtest/gtest.h>

#include "fsw/shared/patience.hpp"

namespace ilp {
namespace {

constexpr std::int64_t input = 7;

TEST(PatienceTest, AFaultOfTheInputGivesItUpAtOnce) {
  Patience patience;
  EXPECT_TRUE(patience.failed(input, StatusCode::record_damaged).status.is(StatusCode::record_damaged));
  EXPECT_TRUE(patience.abandoned(input));
}

// A flipped bit in memory says nothing about the input: a keyframe must not lose its result by it.
TEST(PatienceTest, AfterDamagedMemoryTheInputIsTriedAgainButNotForEver) {
  for (const StatusCode fault : {StatusCode::memory_damaged, StatusCode::assertion_failed}) {
    Patience patience;
    EXPECT_TRUE(patience.failed(input, fault).status.is(fault));
    EXPECT_FALSE(patience.abandoned(input));
    for (int attempt = 1; attempt < 100; ++attempt) static_cast<void>(patience.failed(input, fault));
    EXPECT_TRUE(patience.abandoned(input));
  }
}

}  // namespace
}  // namespace ilp
