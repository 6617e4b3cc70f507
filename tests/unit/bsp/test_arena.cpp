// The arena against a simple model: what is in use never overlaps, keeps its content, and comes back when released.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

#include "fsw/base/arena.hpp"
#include "fsw/base/rng.hpp"

namespace ilp {
namespace {

struct Chunk {
  unsigned char* data;
  std::size_t size;
  unsigned char fill;
};

bool intact(const Chunk& chunk) {
  for (std::size_t i = 0; i < chunk.size; ++i) {
    if (chunk.data[i] != chunk.fill) return false;
  }
  return true;
}

class ArenaTest : public ::testing::Test {
 protected:
  static constexpr std::size_t bytes = std::size_t{1} << 20U;
  ArenaTest() : memory(bytes) { arena.init(memory.data(), memory.size()); }
  std::vector<unsigned char> memory;
  Arena arena;
};

TEST_F(ArenaTest, GivesAlignedPiecesInsideTheRegion) {
  for (std::size_t boundary = 1; boundary <= 4096; boundary *= 2) {
    for (std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{17}, std::size_t{5000}}) {
      auto* p = static_cast<unsigned char*>(arena.allocate_aligned(boundary, size));
      ASSERT_NE(p, nullptr);
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(p) % (boundary < 16 ? 16 : boundary), 0U);
      EXPECT_GE(p, memory.data());
      EXPECT_LE(p + size, memory.data() + memory.size());
      EXPECT_GE(arena.usable_size(p), size);
    }
  }
}

TEST_F(ArenaTest, RandomUseNeverOverlapsAndEndsEmpty) {
  Rng rng(7);
  std::vector<Chunk> chunks;
  std::size_t payload = 0;
  for (int step = 0; step < 60000; ++step) {
    const std::uint32_t action = rng.below(10);
    if (action < 5 || chunks.empty()) {
      const std::size_t size = rng.below(2) == 0 ? rng.below(200) : rng.below(30000);
      const std::size_t boundary = std::size_t{1} << rng.below(9);
      auto* p = static_cast<unsigned char*>(arena.allocate_aligned(boundary, size));
      if (p == nullptr) continue;
      const auto fill = static_cast<unsigned char>(step);
      std::memset(p, fill, size);
      chunks.push_back({p, size, fill});
      payload += size;
    } else {
      Chunk& chunk = chunks[rng.below(static_cast<std::uint32_t>(chunks.size()))];
      ASSERT_TRUE(intact(chunk)) << "step " << step;
      if (action < 7) {
        const std::size_t size = 1 + rng.below(30000);
        auto* p = static_cast<unsigned char*>(arena.reallocate(chunk.data, size));
        if (p == nullptr) continue;
        Chunk kept{p, size < chunk.size ? size : chunk.size, chunk.fill};
        ASSERT_TRUE(intact(kept)) << "step " << step;
        payload += size - chunk.size;
        std::memset(p, chunk.fill, size);
        chunk = {p, size, chunk.fill};
      } else {
        arena.release(chunk.data);
        payload -= chunk.size;
        chunk = chunks.back();
        chunks.pop_back();
      }
    }
    ASSERT_GE(arena.stats().in_use, payload);
  }
  EXPECT_GT(arena.stats().failed, 0U) << "the region was never filled: the test is too tame";
  for (const Chunk& chunk : chunks) {
    EXPECT_TRUE(intact(chunk));
    arena.release(chunk.data);
  }
  EXPECT_EQ(arena.stats().in_use, 0U);
  EXPECT_EQ(arena.stats().misuse, 0U);
  // Everything has merged again: one block takes nearly the whole region.
  EXPECT_NE(arena.allocate(bytes - 64), nullptr);
}

TEST_F(ArenaTest, ExhaustionIsCountedFlaggedAndSurvived) {
  EXPECT_FALSE(arena.exhausted());
  void* kept = arena.allocate(1000);
  EXPECT_EQ(arena.allocate(bytes), nullptr);
  EXPECT_EQ(arena.allocate(SIZE_MAX), nullptr);
  EXPECT_EQ(arena.allocate_aligned(std::size_t{1} << 30U, 8), nullptr);
  EXPECT_EQ(arena.reallocate(kept, bytes), nullptr);
  EXPECT_EQ(arena.stats().failed, 4U);
  EXPECT_TRUE(arena.exhausted());
  arena.clear_exhausted();
  EXPECT_FALSE(arena.exhausted());
  EXPECT_EQ(arena.usable_size(kept), 1008U);
  EXPECT_NE(arena.allocate(1000), nullptr);
}

TEST_F(ArenaTest, MisuseIsCountedAndIgnored) {
  void* p = arena.allocate(100);
  int elsewhere = 0;
  arena.release(&elsewhere);
  arena.release(nullptr);
  arena.release(p);
  arena.release(p);
  EXPECT_EQ(arena.stats().misuse, 2U);
  EXPECT_EQ(arena.stats().in_use, 0U);
}

TEST_F(ArenaTest, ReallocationGrowsInPlaceIntoFreeSpace) {
  void* p = arena.allocate(100);
  EXPECT_EQ(arena.reallocate(p, 100000), p);
  EXPECT_EQ(arena.reallocate(p, 10), p);
  EXPECT_LE(arena.stats().in_use, 64U);
  void* fence = arena.allocate(16);
  ASSERT_NE(fence, nullptr);
  EXPECT_NE(arena.reallocate(p, 5000), p);
}

TEST_F(ArenaTest, CountsPeakAndHighWater) {
  void* a = arena.allocate(100000);
  void* b = arena.allocate(200000);
  arena.release(a);
  arena.release(b);
  EXPECT_GE(arena.stats().peak, 300000U);
  EXPECT_LE(arena.stats().peak, 300100U);
  EXPECT_GE(arena.stats().high_water, 300000U);
  EXPECT_LE(arena.stats().high_water, 300100U);
}

TEST(Arena, EmptyOrTinyRegionsRefuse) {
  Arena none;
  EXPECT_EQ(none.allocate(1), nullptr);
  unsigned char tiny[40];
  none.init(tiny, sizeof(tiny));
  EXPECT_EQ(none.allocate(1), nullptr);
  none.init(tiny + 1, 3);
  EXPECT_EQ(none.allocate(1), nullptr);
  none.release(tiny);
}

}  // namespace
}  // namespace ilp
