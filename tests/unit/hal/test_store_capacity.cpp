// Room for the log: a reader that stays, and a disk that others fill.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "hal/store/sqlite/page_checksum.hpp"
#include "hal/store/sqlite/reserve.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"
#include "tests/unit/hal/expect_status.hpp"
#include "tests/unit/hal/small_disk.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

using Bytes = std::vector<std::uint8_t>;
constexpr std::size_t image_bytes = 100'000;

Status put_image(Store& store, std::int64_t id) {
  Transaction transaction(store);
  ILP_TRY(transaction.begin());
  FrameRecord frame{.id = id};
  frame.image.bytes = image_bytes;
  ILP_TRY(put(store, frame));
  ILP_TRY(write_blob<FrameRecord>(store, "image", id, 0, Bytes(image_bytes, static_cast<std::uint8_t>(id))));
  return transaction.commit();
}

bool has_image(Store& store, std::int64_t id) {
  Bytes image(image_bytes);
  return read_blob<FrameRecord>(store, "image", id, 0, image).ok() &&
         image == Bytes(image_bytes, static_cast<std::uint8_t>(id));
}

/// Somebody's program that reads in one transaction.
class Reader {
 public:
  explicit Reader(const std::string& path) {
    EXPECT_EQ(sqlite3_open_v2(path.c_str(), &database_, SQLITE_OPEN_READONLY, nullptr), SQLITE_OK);
    for (const char* const sql : {"BEGIN", "SELECT count(*) FROM frame"}) {
      EXPECT_EQ(sqlite3_exec(database_, sql, nullptr, nullptr, nullptr), SQLITE_OK);
    }
  }
  ~Reader() { sqlite3_close(database_); }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

 private:
  sqlite3* database_ = nullptr;
};

class StoreCapacity : public testing::Test {
 protected:
  [[nodiscard]] static std::int64_t log_bytes(const std::string& path) {
    return static_cast<std::int64_t>(fs::file_size(path + "-wal"));
  }
  /// Writes a file until the disk has no room.
  static void fill(const std::string& path) {
    const int file = open(path.c_str(), O_WRONLY | O_CREAT, 0644);
    ASSERT_GE(file, 0);
    const Bytes block(4096, 1);
    while (write(file, block.data(), block.size()) > 0) {
    }
    close(file);
  }

  test::TemporaryFolder folder_;
  std::string path_ = folder_ / "flight.db";
};

TEST_F(StoreCapacity, AReaderThatStaysIsToldAndItsLogIsBounded) {
  SqliteStore store;
  ASSERT_OK(store.open(path_.c_str()));
  ASSERT_OK(put_image(store, 1));
  EXPECT_OK(store.take_updates());
  std::int64_t id = 1;
  for (int round = 0; round < 2; ++round) {
    auto reader = std::make_unique<Reader>(path_);
    Status status;
    Status updates;
    while (status.ok() && id < 1000) {
      status = put_image(store, id + 1);
      if (status.ok()) ++id;
      if (updates.ok()) updates = store.take_updates();
      EXPECT_TRUE(updates.ok() || status.ok()) << "it has to be told before nothing can be stored";
      if (!updates.ok()) break;
    }
    EXPECT_STATUS(updates, store_log_held);
    EXPECT_GT(updates.a, sqlite_log_bytes / 2);
    EXPECT_EQ(updates.b, sqlite_log_bytes);
    while (status.ok() && id < 1000) {
      status = put_image(store, id + 1);
      if (status.ok()) ++id;
    }
    EXPECT_STATUS(status, store_full);
    EXPECT_EQ(status.b, sqlite_log_bytes);
    for (int i = 0; i < 20; ++i) EXPECT_STATUS(put_image(store, 5000), store_full);
    EXPECT_LE(log_bytes(path_), sqlite_log_bytes + 2 * static_cast<std::int64_t>(image_bytes));
    EXPECT_OK(store.take_updates()) << "it is told once";
    // Reading goes on, and when the reader has gone so does writing.
    EXPECT_TRUE(has_image(store, id));
    reader.reset();
    ASSERT_OK(put_image(store, ++id));
    EXPECT_OK(store.take_updates());
  }
  EXPECT_FALSE(store.damaged());
  store.close();
  ASSERT_OK(store.open(path_.c_str()));
  for (std::int64_t held = 1; held <= id; ++held) ASSERT_TRUE(has_image(store, held)) << held;
}

TEST_F(StoreCapacity, AReaderOfTheNewestStateIsNotInTheWay) {
  SqliteStore store;
  ASSERT_OK(store.open(path_.c_str()));
  for (std::int64_t id = 1; id <= 200; ++id) {
    const Reader reader(path_);
    ASSERT_OK(put_image(store, id % 10));
    EXPECT_OK(store.take_updates());
  }
}

/// A database on a small disk that others fill while its log has images that are not in it yet.
class FullDisk : public StoreCapacity {
 protected:
  void SetUp() override {
    if (!disk_.mounted()) GTEST_SKIP() << "no right to mount a small disk here";
    path_ = disk_.path() + "/flight.db";
    ASSERT_OK(store_.open(path_.c_str()));
    ASSERT_OK(store_.limit(1 << 30));
    reserve_ = reserved_bytes(path_.c_str());
    ASSERT_GT(reserve_, 2 << 20);
    while (log_bytes(path_) < 600'000) ASSERT_OK(put_image(store_, ++images_));
    fill(others_);
    Status status;
    while (status.ok() && images_ < 100) {
      status = put_image(store_, images_ + 1);
      if (status.ok()) ++images_;
    }
    ASSERT_EQ(status.code, StatusCode::store_full);
    EXPECT_EQ(reserved_bytes(path_.c_str()), reserve_) << "it is for copying the log";
  }
  void expect_images() {
    for (std::int64_t id = 1; id <= images_; ++id) EXPECT_TRUE(has_image(store_, id)) << id;
    EXPECT_OK(store_.check());
  }

  const test::SmallDisk disk_{folder_ / "disk", 24};
  const std::string others_ = disk_.path() + "/others";
  SqliteStore store_;
  std::int64_t reserve_ = 0;
  std::int64_t images_ = 0;
};

TEST_F(FullDisk, ErasingGoesOnAndTheReserveIsMadeAgainWhenThereIsRoom) {
  for (std::int64_t id = 1; id <= 3; ++id) {
    EXPECT_STATUS(put_image(store_, 900), store_full) << "its room is for the log";
    ASSERT_OK(store_.begin());
    EXPECT_OK(store_.erase(record_info<FrameRecord>(), id));
    EXPECT_OK(store_.commit());
    EXPECT_OK(put_image(store_, id));
  }
  EXPECT_EQ(reserved_bytes(path_.c_str()), 0) << "the log was copied into it";
  fs::remove(others_);
  ASSERT_OK(put_image(store_, ++images_));
  EXPECT_EQ(reserved_bytes(path_.c_str()), reserve_);
  expect_images();
}

TEST_F(FullDisk, TheEndIsInOrderAndTheNextStartTooLosesNothing) {
  store_.close();
  EXPECT_FALSE(fs::exists(path_ + "-wal")) << "the log should be in the database";
  EXPECT_FALSE(fs::exists(path_ + "-reserve"));
  ASSERT_OK(store_.open(path_.c_str()));
  expect_images();
}

}  // namespace
}  // namespace ilp
