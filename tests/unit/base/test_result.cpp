#include <gtest/gtest.h>

#include "fsw/base/result.hpp"

namespace ilp {
namespace {

Result<bool> odd(int number) {
  if (number < 0) return StatusCode::invalid_argument;
  return number % 2 != 0;
}

Result<int> halves(int number) {
  ILP_TAKE(const bool is_odd, odd(number));
  if (is_odd) return Status{StatusCode::not_ready, number};
  ILP_TAKE(const bool half_is_odd, odd(number / 2));
  return half_is_odd ? 1 : 2;
}

Status half_twice(int number, int& times) {
  ILP_TAKE(times, halves(number));
  return {};
}

TEST(Result, HasAValueOrAFault) {
  EXPECT_TRUE(odd(3).ok());
  EXPECT_TRUE(odd(3).value());
  EXPECT_TRUE(odd(4).ok());
  EXPECT_FALSE(odd(4).value());
  EXPECT_FALSE(odd(-1).ok());
  EXPECT_TRUE(odd(-1).status().is(StatusCode::invalid_argument));
  EXPECT_FALSE(odd(-1).value());
}

TEST(Result, OfACallIsTakenOrItsFaultReturned) {
  EXPECT_EQ(halves(4).value(), 2);
  EXPECT_EQ(halves(6).value(), 1);
  EXPECT_TRUE(halves(5).status().is(StatusCode::not_ready));
  EXPECT_EQ(halves(5).status().a, 5);
  EXPECT_TRUE(halves(-2).status().is(StatusCode::invalid_argument));
  int times = 0;
  EXPECT_TRUE(half_twice(4, times).ok());
  EXPECT_EQ(times, 2);
  EXPECT_FALSE(half_twice(3, times).ok());
  EXPECT_EQ(times, 2);
}

}  // namespace
}  // namespace ilp
