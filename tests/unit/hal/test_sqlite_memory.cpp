// SQLite in a fixed arena: how much a flight takes, and what happens when there is no more.
#include <gtest/gtest.h>

#include <cstdio>
#include <vector>

#include "hal/store/sqlite/sqlite_memory.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"
#include "tests/unit/hal/expect_status.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {

using Bytes = std::vector<std::uint8_t>;

alignas(16) std::byte region[limits::sqlite_arena_bytes];
Arena arena;

/// SQLite is configured once per process, so all tests share the arena.
class SqliteMemory : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    arena.init(region, sizeof(region));
    ASSERT_OK(configure_sqlite_memory(arena));
    EXPECT_STATUS(configure_sqlite_memory(arena), store_error) << "too late the second time";
  }
  test::TemporaryFolder folder_;
  std::string path_ = folder_ / "flight.db";
};

/// Takes all of the arena but `capacity` bytes, in one block or in many.
class Hog {
 public:
  explicit Hog(std::size_t capacity) {
    void* const spared = arena.allocate(capacity);
    for (std::size_t bytes = sizeof(region); bytes >= 16; bytes /= 2) {
      while (void* block = arena.allocate(bytes)) blocks_.push_back(block);
    }
    arena.release(spared);
  }
  ~Hog() {
    for (void* block : blocks_) arena.release(block);
  }
  Hog(const Hog&) = delete;
  Hog& operator=(const Hog&) = delete;

 private:
  std::vector<void*> blocks_;
};

Status put_frame(Store& store, std::int64_t id, std::uint32_t bytes, std::uint8_t value) {
  Transaction transaction(store);
  ILP_TRY(transaction.begin());
  FrameRecord frame{.id = id};
  frame.image.bytes = bytes;
  ILP_TRY(put(store, frame));
  ILP_TRY(write_blob<FrameRecord>(store, "image", id, 0, Bytes(bytes, value)));
  return transaction.commit();
}

Status put_depth(Store& store, std::int64_t id) {
  Transaction transaction(store);
  ILP_TRY(transaction.begin());
  DepthRecord depth{.id = id};
  depth.values.bytes = limits::max_image_pixels * 2;
  depth.sigma.bytes = limits::max_image_pixels;
  ILP_TRY(put(store, depth));
  MaskRecord mask{.id = id};
  mask.code.bytes = limits::max_image_pixels / 8;
  ILP_TRY(put(store, mask));
  ILP_TRY(write_blob<DepthRecord>(store, "values", id, 0, Bytes(depth.values.bytes, 1)));
  ILP_TRY(write_blob<DepthRecord>(store, "sigma", id, 0, Bytes(depth.sigma.bytes, 2)));
  return transaction.commit();
}

TEST_F(SqliteMemory, AFlightFitsTheArena) {
  SqliteStore store;
  ASSERT_OK(store.open(path_.c_str()));
  const std::size_t opened = arena.stats().in_use;
  Bytes image(limits::max_image_pixels);
  for (std::int64_t id = 1; id <= 25; ++id) {
    ASSERT_OK(put_frame(store, id, limits::max_image_pixels, 1));
    ASSERT_OK(put_depth(store, id));
    ASSERT_OK(read_blob<FrameRecord>(store, "image", 1 + id / 2, 0, image));
    Transaction transaction(store);
    ASSERT_OK(transaction.begin());
    if (id > 5) {
      ASSERT_OK(store.erase(record_info<DepthRecord>(), id - 5));
      ASSERT_OK(store.erase(record_info<MaskRecord>(), id - 5));
    }
    ASSERT_OK(transaction.commit());
  }
  EXPECT_EQ(arena.stats().failed, 0U);
  EXPECT_LT(arena.stats().high_water, sizeof(region) * 3 / 4) << "a quarter in reserve";
  std::printf("SQLite's arena: %zu KiB once open, peak %zu KiB, high water %zu KiB of %zu KiB\n", opened / 1024,
              arena.stats().peak / 1024, arena.stats().high_water / 1024, sizeof(region) / 1024);
  store.close();
  EXPECT_LT(arena.stats().in_use, 65536U) << "a closed store holds memory";
}

TEST_F(SqliteMemory, ExhaustedArenaIsAStatusAndTheFlightGoesOn) {
  SqliteStore store;
  ASSERT_OK(store.open(path_.c_str()));
  ASSERT_OK(put_frame(store, 1, 20000, 1));
  int refused = 0;
  std::int64_t id = 2;
  for (std::size_t capacity = 0; capacity < 100000; capacity = capacity * 5 / 4 + 40, ++id) {
    Status status;
    Bytes image(20000);
    {
      const Hog hog(capacity);
      // A larger image than before, so that the page cache has to grow.
      status = put_frame(store, id, 40000 * static_cast<std::uint32_t>(id), static_cast<std::uint8_t>(id));
      const Status read = read_blob<FrameRecord>(store, "image", 1, 0, image);
      EXPECT_TRUE(read.ok() || read.is(StatusCode::arena_exhausted)) << status_name(read.code);
      RecordMask changed = 0;
      const Status polled = store.poll(changed);
      EXPECT_TRUE(polled.ok() || polled.is(StatusCode::arena_exhausted)) << status_name(polled.code);
    }
    if (!status.ok()) {
      ++refused;
      EXPECT_EQ(status.code, StatusCode::arena_exhausted) << "room " << capacity;
      EXPECT_EQ(status.a, sqlite_arena_number);
      EXPECT_GT(status.b, 0);
    }
    FrameRecord frame;
    EXPECT_EQ(get(store, id, frame).ok(), status.ok()) << "room " << capacity;
    ASSERT_OK(read_blob<FrameRecord>(store, "image", 1, 0, image));
    EXPECT_EQ(image, Bytes(20000, 1));
    ASSERT_OK(put_frame(store, 1, 20000, 1)) << "room " << capacity;
  }
  EXPECT_GT(refused, 5) << "the arena was never exhausted: the test tests nothing";
  EXPECT_EQ(arena.stats().misuse, 0U);
}

TEST_F(SqliteMemory, ExhaustedArenaAtOpenLeavesTheDatabaseUsable) {
  int refused = 0;
  for (std::size_t capacity = 0; capacity < 2000000; capacity = capacity * 4 / 3 + 100) {
    SqliteStore store;
    {
      const Hog hog(capacity);
      const Status status = store.open(path_.c_str());
      if (!status.ok()) {
        ++refused;
        EXPECT_EQ(status.code, StatusCode::arena_exhausted) << "room " << capacity;
      }
    }
    ASSERT_OK(store.open(path_.c_str())) << "room " << capacity;
    ASSERT_OK(put_frame(store, 1, 100, 1));
  }
  EXPECT_GT(refused, 10);
}

}  // namespace
}  // namespace ilp
