// FixedVector refuses what does not fit and keeps what it has.
#include "fsw/base/fixed_vector.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <type_traits>

namespace ilp {
namespace {

using Small = FixedVector<int, 3>;
static_assert(std::is_trivially_copyable_v<Small>, "checkpoints copy it as bytes");

TEST(FixedVector, FillsToItsCapacityAndNoFurther) {
  Small v;
  EXPECT_TRUE(v.empty());
  EXPECT_EQ(Small::capacity(), 3U);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(v.push_back(10 + i));
  EXPECT_TRUE(v.full());
  EXPECT_FALSE(v.push_back(99));
  EXPECT_EQ(v.size(), 3U);
  EXPECT_EQ(v[0], 10);
  EXPECT_EQ(v.back(), 12);
}

TEST(FixedVector, ResizeClearsWhatItAdds) {
  Small v;
  ASSERT_TRUE(v.push_back(1));
  ASSERT_TRUE(v.push_back(2));
  ASSERT_TRUE(v.resize(1));
  ASSERT_TRUE(v.resize(3));
  EXPECT_EQ(v[0], 1);
  EXPECT_EQ(v[1], 0);
  EXPECT_EQ(v[2], 0);
  EXPECT_FALSE(v.resize(4));
  EXPECT_EQ(v.size(), 3U);
}

TEST(FixedVector, PopClearAndIterate) {
  Small v;
  for (int i = 1; i <= 3; ++i) ASSERT_TRUE(v.push_back(i));
  EXPECT_EQ(std::accumulate(v.begin(), v.end(), 0), 6);
  v.pop_back();
  EXPECT_EQ(v.back(), 2);
  const Small copy = v;
  v.clear();
  EXPECT_TRUE(v.empty());
  EXPECT_EQ(v.begin(), v.end());
  EXPECT_EQ(copy.size(), 2U);
  EXPECT_EQ(copy.end() - copy.begin(), 2);
}

TEST(FixedVector, WhatIsErasedLeavesTheOthersInTheirOrder) {
  const auto without = [](std::size_t index) {
    Small v;
    for (int i = 1; i <= 3; ++i) EXPECT_TRUE(v.push_back(i));
    v.erase(index);
    return std::vector<int>(v.begin(), v.end());
  };
  EXPECT_EQ(without(0), (std::vector<int>{2, 3}));
  EXPECT_EQ(without(1), (std::vector<int>{1, 3}));
  EXPECT_EQ(without(2), (std::vector<int>{1, 2}));
  EXPECT_EQ(without(3), (std::vector<int>{1, 2, 3})) << "there is no such element";
  Small none;
  none.erase(0);
  EXPECT_TRUE(none.empty());
}

TEST(FixedVector, ASizeThatAFlippedBitChangedLeadsNowhere) {
  struct alignas(8) Neighbours {
    Small vector;
    std::int32_t behind[64] = {};
  };
  for (unsigned bit = 2; bit < 32; ++bit) {
    Neighbours n;
    ASSERT_TRUE(n.vector.push_back(1));
    auto* size = reinterpret_cast<std::uint32_t*>(&n.vector) + 3;
    ASSERT_EQ(*size, 1U);
    *size ^= 1U << bit;
    EXPECT_EQ(n.vector.size(), 3U);
    EXPECT_EQ(n.vector.end() - n.vector.begin(), 3);
    EXPECT_FALSE(n.vector.push_back(7));
    n.vector.back() = 8;
    EXPECT_EQ(n.behind[0], 0);
    n.vector.pop_back();
    EXPECT_EQ(n.vector.size(), 2U);
  }
}

}  // namespace
}  // namespace ilp
