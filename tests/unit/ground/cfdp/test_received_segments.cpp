#include "sim/ground/cfdp/cfdp_receiver.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <random>

namespace ilp::ground_cfdp {
namespace {

/// The same octet by octet.
class Reference {
 public:
  std::uint64_t add(std::uint64_t offset, std::span<const std::uint8_t> bytes) {
    std::uint64_t added = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      if (octets_[offset + i]) continue;
      octets_[offset + i] = bytes[i];
      ++added;
    }
    return added;
  }
  [[nodiscard]] bool held(std::uint64_t at) const { return octets_[at].has_value(); }
  [[nodiscard]] std::uint8_t at(std::uint64_t at) const { return *octets_[at]; }

 private:
  std::vector<std::optional<std::uint8_t>> octets_ = std::vector<std::optional<std::uint8_t>>(1200);
};

TEST(ReceivedSegments, AreThoseOfAListOfOctets) {
  std::mt19937 random(1);
  for (int round = 0; round < 300; ++round) {
    ReceivedSegments segments;
    Reference reference;
    const std::uint64_t longest = 1 + random() % 200;
    for (int i = 0; i < 60; ++i) {
      std::vector<std::uint8_t> bytes(random() % longest);
      for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
      const std::uint64_t offset = random() % 900;
      ASSERT_EQ(segments.add(offset, bytes), reference.add(offset, bytes));
      const std::uint64_t begin = random() % 1000, end = begin + random() % 200;
      std::uint64_t at = begin;
      for (const cfdp::Gap& gap : segments.gaps(begin, end, 10000)) {
        ASSERT_LT(gap.begin, gap.end);
        for (; at < gap.begin; ++at) ASSERT_TRUE(reference.held(at));
        for (; at < gap.end; ++at) ASSERT_FALSE(reference.held(at));
        ASSERT_TRUE(at == end || reference.held(at)) << "a gap in two parts";
      }
      for (; at < end; ++at) ASSERT_TRUE(reference.held(at));
      ASSERT_EQ(segments.whole(end), segments.gaps(0, end, 1).empty());
    }
    std::uint64_t end = 0;
    while (end < 1200 && reference.held(end)) ++end;
    const std::vector<std::uint8_t> file = segments.file(end);
    ASSERT_EQ(file.size(), end);
    for (std::uint64_t at = 0; at < end; ++at) ASSERT_EQ(file[at], reference.at(at));
  }
}

TEST(ReceivedSegments, AsManyGapsAsAreWantedFromWhereTheyAreWanted) {
  ReceivedSegments segments;
  const std::vector<std::uint8_t> octet(1);
  for (std::uint64_t at = 1; at < 100; at += 2) segments.add(at, octet);
  const std::vector<cfdp::Gap> gaps = segments.gaps(11, 1000, 3);
  ASSERT_EQ(gaps.size(), 3U);
  EXPECT_EQ(gaps[0].begin, 12U);
  EXPECT_EQ(gaps[0].end, 13U);
  EXPECT_EQ(gaps[2].begin, 16U);
}

}  // namespace
}  // namespace ilp::ground_cfdp
