// Who may give commands, and how long one who guesses has to wait, at times that the test chooses.
#include "sim/ground/serve/token_guard.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

namespace ilp::serve {
namespace {

using namespace std::chrono_literals;
using Verdict = TokenGuard::Verdict;

const std::string token = "only-for-this-test-7c1f9a";
constexpr std::uint32_t operators = 0x7F000001, guessers = 0x0A000002;

class TokenGuardTest : public testing::Test {
 protected:
  Verdict right(std::uint32_t client = guessers) { return guard.check(token, client, now); }
  Verdict wrong(std::uint32_t client = guessers) { return guard.check("guess", client, now); }
  /// Until the client is not heard for a while.
  void guess_too_often() {
    for (unsigned i = 0; i <= TokenGuard::free_tries; ++i) ASSERT_EQ(wrong(), Verdict::wrong) << i;
    ASSERT_EQ(wrong(), Verdict::wait);
  }
  TokenGuard guard{token};
  TokenGuard::Clock::time_point now{1h};
};

TEST_F(TokenGuardTest, OnlyTheWholeTokenIsRight) {
  EXPECT_EQ(right(), Verdict::right);
  for (const std::string& other : {token.substr(0, token.size() - 1), token + "x", token.substr(1), std::string(),
                                   token + std::string(1, '\0'), std::string(token.size(), 'o')}) {
    EXPECT_EQ(TokenGuard(token).check(other, guessers, now), Verdict::wrong) << other;
  }
}

TEST_F(TokenGuardTest, WaitsDoubleUpToAMinuteAndTheRightTokenHasToWaitToo) {
  guess_too_often();
  for (const int seconds : {1, 2, 4, 8, 16, 32, 60, 60}) {
    SCOPED_TRACE(seconds);
    EXPECT_EQ(guard.wait_s(guessers, now), seconds);
    now += std::chrono::seconds(seconds) - 1ms;
    EXPECT_EQ(right(), Verdict::wait);
    EXPECT_EQ(guard.wait_s(guessers, now), 1);
    now += 1ms;
    EXPECT_EQ(guard.wait_s(guessers, now), 0);
    EXPECT_EQ(right(), Verdict::right);
    EXPECT_EQ(wrong(), Verdict::wrong);
  }
}

TEST_F(TokenGuardTest, ARightTokenBetweenGivesNoFurtherGuesses) {
  for (unsigned i = 0; i <= TokenGuard::free_tries; ++i) {
    EXPECT_EQ(wrong(), Verdict::wrong);
    EXPECT_EQ(right(), i < TokenGuard::free_tries ? Verdict::right : Verdict::wait) << i;
  }
  EXPECT_EQ(wrong(), Verdict::wait);
}

TEST_F(TokenGuardTest, TwoMinutesWithoutAWrongTokenAreForgiven) {
  guess_too_often();
  now += 2min;
  EXPECT_EQ(wrong(), Verdict::wrong);
  EXPECT_EQ(guard.wait_s(guessers, now), 2) << "not yet";
  now += 2min + 1s;
  guess_too_often();
  EXPECT_EQ(guard.wait_s(guessers, now), 1);
}

TEST_F(TokenGuardTest, AnotherComputerDoesNotWait) {
  guess_too_often();
  EXPECT_EQ(right(operators), Verdict::right);
  EXPECT_EQ(guard.wait_s(operators, now), 0);
}

TEST_F(TokenGuardTest, OfManyComputersTheOneThatWasWrongLongestAgoIsForgotten) {
  guess_too_often();
  for (std::uint32_t other = 0; other < 63; ++other) {
    now += 1ms;
    EXPECT_EQ(wrong(0x0B000000 + other), Verdict::wrong);
  }
  EXPECT_EQ(right(), Verdict::wait) << "64 are remembered";
  EXPECT_EQ(wrong(0x0C000000), Verdict::wrong);
  EXPECT_EQ(right(), Verdict::right);
}

TEST_F(TokenGuardTest, EveryWrongTokenIsCounted) {
  guess_too_often();
  static_cast<void>(right());
  EXPECT_EQ(guard.wrong(), TokenGuard::free_tries + 2);
}

TEST(TokenOfTheEnvironment, IsThereForNoProgramThatIsStartedLater) {
  ASSERT_EQ(setenv("ILP_COMMAND_TOKEN", token.c_str(), 1), 0);
  EXPECT_EQ(read_token(""), token);
  EXPECT_EQ(std::getenv("ILP_COMMAND_TOKEN"), nullptr);
}

}  // namespace
}  // namespace ilp::serve
