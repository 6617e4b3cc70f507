// Who may give commands, and when the operator is told of who may not, at times that the test chooses.
#include "sim/ground/serve/token_guard.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

namespace ilp::serve {
namespace {

using namespace std::chrono_literals;

const std::string token = "only-for-this-test-7c1f9a";

TEST(TokenGuardTest, OnlyTheWholeTokenIsRight) {
  const TokenGuard guard(token);
  EXPECT_TRUE(guard.is_right(token));
  for (const std::string& other : {token.substr(0, token.size() - 1), token + "x", token.substr(1), std::string(),
                                   token + std::string(1, '\0'), std::string(token.size(), 'o')}) {
    EXPECT_FALSE(guard.is_right(other)) << other;
  }
}

TEST(TokenGuardTest, EveryWrongTokenIsCountedAndAFloodOfThemIsToldOnceInTenSeconds) {
  TokenGuard guard(token);
  TokenGuard::Clock::time_point now{1h};
  EXPECT_EQ(guard.count_wrong(now), 1U);
  for (int i = 0; i < 998; ++i) EXPECT_EQ(guard.count_wrong(now += 10ms), std::nullopt);
  EXPECT_TRUE(guard.is_right(token));
  EXPECT_EQ(guard.count_wrong(now += 20ms), 1000U);
  EXPECT_EQ(guard.count_wrong(now += 9999ms), std::nullopt);
  EXPECT_EQ(guard.count_wrong(now += 1ms), 1002U);
}

TEST(TokenOfTheEnvironment, IsThereForNoProgramThatIsStartedLater) {
  ASSERT_EQ(setenv("ILP_COMMAND_TOKEN", token.c_str(), 1), 0);
  EXPECT_EQ(read_token(""), token);
  EXPECT_EQ(std::getenv("ILP_COMMAND_TOKEN"), nullptr);
}

}  // namespace
}  // namespace ilp::serve
