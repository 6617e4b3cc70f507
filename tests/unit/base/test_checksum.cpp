#include "fsw/base/checksum.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

#include "fsw/base/memory_sum.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/base/vector_width.hpp"

namespace ilp {
namespace {

std::vector<std::byte> random_bytes(std::size_t size) {
  Rng rng(7);
  std::vector<std::byte> bytes(size);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(rng.next());
  return bytes;
}

TEST(Checksum64, EverySingleBitOfEveryLengthIsNoticed) {
  for (std::size_t size = 0; size <= 70; ++size) {
    std::vector<std::byte> bytes = random_bytes(size);
    std::set<std::uint64_t> sums{checksum64(bytes)};
    for (std::size_t bit = 0; bit < 8 * size; ++bit) {
      bytes[bit / 8] ^= static_cast<std::byte>(1U << bit % 8);
      EXPECT_TRUE(sums.insert(checksum64(bytes)).second) << size << " bytes, bit " << bit;
      bytes[bit / 8] ^= static_cast<std::byte>(1U << bit % 8);
    }
  }
}

TEST(Checksum64, OrderLengthAndWhatWentBeforeCount) {
  const std::vector<std::byte> bytes = random_bytes(64);
  const std::span<const std::byte> all = bytes;
  std::vector<std::byte> swapped(bytes.begin() + 8, bytes.begin() + 16);
  swapped.insert(swapped.end(), bytes.begin(), bytes.begin() + 8);
  EXPECT_NE(checksum64(all.first(16)), checksum64(swapped));
  const std::vector<std::byte> zeros(40);
  std::set<std::uint64_t> sums;
  for (std::size_t size = 0; size <= 40; ++size) sums.insert(checksum64(std::span(zeros).first(size)));
  EXPECT_EQ(sums.size(), 41U);
  EXPECT_NE(checksum64(all, 1), checksum64(all, 2));
}

TEST(MemorySum64, EverySingleBitOfEveryLengthIsNoticedInBothWidths) {
  for (const std::size_t size : {40U, 511U, 512U, 575U, 700U}) {
    std::vector<std::byte> bytes = random_bytes(size);
    const std::uint64_t whole = memory_sum64(bytes);
    std::set<std::uint64_t> sums{whole};
    for (std::size_t bit = 0; bit < 8 * size; ++bit) {
      bytes[bit / 8] ^= static_cast<std::byte>(1U << bit % 8);
      EXPECT_TRUE(sums.insert(memory_sum64(bytes)).second) << size << " bytes, bit " << bit;
      bytes[bit / 8] ^= static_cast<std::byte>(1U << bit % 8);
    }
    use_vectors(VectorWidth::bytes16);
    EXPECT_EQ(memory_sum64(bytes), whole);
    use_vectors(widest_vectors());
  }
}

TEST(MemorySum64, TheSameChangeOfTwoWordsIsNoticed) {
  std::vector<std::byte> bytes(8192);
  const std::uint64_t whole = memory_sum64(bytes);
  // The highest bit of a word is lost in a sum of two.
  for (const std::size_t bit : {0U, 31U, 32U, 63U}) {
    for (std::size_t word = 1; word < bytes.size() / 8; ++word) {
      for (const std::size_t at : {std::size_t{0}, word})
        bytes[8 * at + bit / 8] ^= static_cast<std::byte>(1U << bit % 8);
      EXPECT_NE(memory_sum64(bytes), whole) << "bit " << bit << " of words 0 and " << word;
      for (const std::size_t at : {std::size_t{0}, word})
        bytes[8 * at + bit / 8] ^= static_cast<std::byte>(1U << bit % 8);
    }
  }
}

TEST(MemorySum64, OrderAndWhatWentBeforeCount) {
  std::vector<std::byte> bytes = random_bytes(1024);
  const std::uint64_t whole = memory_sum64(bytes);
  EXPECT_NE(memory_sum64(bytes, 1), memory_sum64(bytes, 2));
  std::rotate(bytes.begin(), bytes.begin() + 64, bytes.end());
  EXPECT_NE(memory_sum64(bytes), whole);
}

struct Thing {
  std::int64_t value = 0;
  double more[5] = {};
};

TEST(Guarded, WhateverBitChangesTheThingComesBack) {
  Thing thing{42, {1, 2, 3, 4, 5}};
  Guarded<Thing> guard;
  guard.seal(thing);
  EXPECT_EQ(guard.check(thing), GuardFinding::intact);
  for (std::size_t bit = 0; bit < 8 * sizeof(Thing); ++bit) {
    reinterpret_cast<std::uint8_t*>(&thing)[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    EXPECT_EQ(guard.check(thing), GuardFinding::mended);
    EXPECT_EQ(thing.value, 42);
    EXPECT_EQ(guard.check(thing), GuardFinding::intact);
  }
}

TEST(Guarded, ABitInTheGuardItselfIsNoDamageAndOneInEachIsALoss) {
  Thing thing{42, {1, 2, 3, 4, 5}};
  for (std::size_t bit = 0; bit < 8 * sizeof(Guarded<Thing>); ++bit) {
    Guarded<Thing> guard;
    guard.seal(thing);
    reinterpret_cast<std::uint8_t*>(&guard)[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    EXPECT_EQ(guard.check(thing), GuardFinding::intact);
    EXPECT_EQ(thing.value, 42);
  }
  Guarded<Thing> guard;
  guard.seal(thing);
  thing.value = 43;
  reinterpret_cast<std::uint8_t*>(&guard)[9] ^= 1U;
  EXPECT_EQ(guard.check(thing), GuardFinding::lost);
  EXPECT_EQ(thing.value, 43);
}

}  // namespace
}  // namespace ilp
