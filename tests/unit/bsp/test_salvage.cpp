// A damaged database: what can be read of it is in the new one, and the same damage is never opened twice.
#include <gtest/gtest.h>
#include <signal.h>
#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <set>
#include <thread>
#include <vector>

#include "bsp/flight/flight_store.hpp"
#include "hal/store/sqlite/checked_vfs.hpp"
#include "hal/store/sqlite/page_checksum.hpp"
#include "hal/store/sqlite/quarantine.hpp"
#include "tests/support/failing_calls.hpp"
#include "tests/support/said.hpp"
#include "tests/support/store_records.hpp"
#include "tests/unit/hal/expect_status.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

using Bytes = std::vector<std::uint8_t>;

constexpr std::int64_t frames = 60;
constexpr std::int64_t strips = 2000;
constexpr std::size_t image_bytes = 10'000;
constexpr std::int64_t first_keyframe = 0x11220000;

Bytes image_of(std::int64_t id) {
  Bytes image(image_bytes);
  for (std::size_t i = 0; i < image.size(); ++i) image[i] = static_cast<std::uint8_t>(id + static_cast<int>(i / 100));
  return image;
}

class SalvageTest : public testing::Test {
 protected:
  std::unique_ptr<FlightStore> make() { return std::make_unique<FlightStore>(sqlite_, memory_); }

  static void fill(Store& store) {
    for (std::int64_t id = 1; id <= frames; ++id) {
      Transaction transaction(store);
      ASSERT_OK(transaction.begin());
      FrameRecord frame{.id = id, .time_ns = 1000 * id};
      frame.image.bytes = image_bytes;
      ASSERT_OK(put(store, frame));
      ASSERT_OK(write_blob<FrameRecord>(store, "image", id, 0, image_of(id)));
      ASSERT_OK(transaction.commit());
    }
    Transaction transaction(store);
    ASSERT_OK(transaction.begin());
    for (std::int64_t id = 1; id <= strips; ++id) {
      StripRecord strip{.id = id, .first_keyframe_id = first_keyframe + id};
      ASSERT_OK(put(store, strip));
    }
    for (std::int64_t id = 1; id <= 5; ++id) {
      CheckpointRecord checkpoint;
      checkpoint.id = 200 + id;  // of no component, so that the build accepts it
      checkpoint.cursor = 100 + id;
      ASSERT_OK(put(store, checkpoint));
      SettingRecord setting{.id = id, .value = 0.5 * static_cast<double>(id)};
      ASSERT_OK(put(store, setting));
    }
    IdentityRecord identity{.life = 3};
    ASSERT_OK(put(store, identity));
    ASSERT_OK(transaction.commit());
  }
  /// A database whose flight ended in order.
  void fly() {
    const auto store = make();
    ASSERT_OK(store->open(path_.c_str(), StoreTrouble::refuse, mission_));
    fill(store->store());
    store->close();
  }

  struct Found {
    std::int64_t strips = 0, frames = 0, images = 0, damaged_images = 0, settings = 0;
  };
  /// Whatever is there is right.
  static Found judge(Store& store) {
    Found found;
    StripRecord strip;
    for (std::int64_t id = 1; id <= strips; ++id) {
      if (!get(store, id, strip).ok()) continue;
      ++found.strips;
      EXPECT_EQ(strip.first_keyframe_id, first_keyframe + id);
    }
    FrameRecord frame;
    for (std::int64_t id = 1; id <= frames; ++id) {
      if (!get(store, id, frame).ok()) continue;
      ++found.frames;
      EXPECT_EQ(frame.time_ns, 1000 * id);
      Bytes image(image_bytes);
      const Status read = read_blob<FrameRecord>(store, "image", id, 0, image);
      if (read.ok()) {
        ++found.images;
        EXPECT_EQ(image, image_of(id));
      } else {
        EXPECT_STATUS(read, record_damaged);
        ++found.damaged_images;
      }
    }
    SettingRecord setting;
    for (std::int64_t id = 1; id <= 5; ++id) {
      if (!get(store, id, setting).ok()) continue;
      ++found.settings;
      EXPECT_EQ(setting.value, 0.5 * static_cast<double>(id));
    }
    return found;
  }
  /// Numbers of the pages with this content.
  std::vector<std::uint32_t> pages_with(const std::string& text) const {
    const std::string bytes = test::text_of(path_);
    std::set<std::uint32_t> pages;
    for (std::size_t at = bytes.find(text); at != std::string::npos; at = bytes.find(text, at + 1)) {
      pages.insert(static_cast<std::uint32_t>(at / page_bytes + 1));
    }
    return {pages.begin(), pages.end()};
  }
  void destroy(std::uint32_t page) const {
    std::fstream file(path_, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(page - 1) * static_cast<std::streamoff>(page_bytes));
    const std::string noise(page_bytes, '\x5A');
    file.write(noise.data(), static_cast<std::streamsize>(noise.size()));
    ASSERT_TRUE(file.good());
  }
  /// A leaf of the strips in the middle, and a page of the image of frame 30.
  void damage() const {
    const std::vector<std::uint32_t> leaves = pages_with("\x11\x22\x03\xE8");
    ASSERT_FALSE(leaves.empty());
    destroy(leaves.front());
    const Bytes image = image_of(30);
    const std::vector<std::uint32_t> pages = pages_with(std::string(image.begin() + 5000, image.begin() + 5300));
    ASSERT_FALSE(pages.empty());
    destroy(pages.front());
  }

  test::TemporaryFolder folder_;
  std::string path_ = folder_ / "flight.db";
  MissionParameters mission_;
  Arena sqlite_;
  alignas(Arena::alignment) static inline std::byte memory_[limits::ram_store_bytes];
};

TEST_F(SalvageTest, WhatCanBeReadIsSavedAndWhatCannotIsCounted) {
  fly();
  damage();
  // The damage is found in flight: the previous process had ended in order, so that the start did not look for it.
  {
    const auto store = make();
    ASSERT_OK(store->open(path_.c_str(), StoreTrouble::fly_on, mission_));
    EXPECT_OK(store->updates());
    EXPECT_FALSE(store->damaged());
    EXPECT_LT(test::records_of<StripRecord>(store->store()).size(), static_cast<std::size_t>(strips));
    EXPECT_TRUE(store->damaged());
  }
  const std::string before = test::text_of(path_);
  EXPECT_STATUS(make()->open(path_.c_str(), StoreTrouble::refuse, mission_), store_damaged);
  EXPECT_TRUE(test::text_of(path_) == before) << "refused, and yet something was changed";

  const auto store = make();
  ASSERT_OK(store->open(path_.c_str(), StoreTrouble::fly_on, mission_));
  EXPECT_STATUS(store->updates(), store_salvaged);
  EXPECT_EQ(store->updates().b, 1);
  EXPECT_TRUE(test::text_of(path_ + ".aside-1") == before);
  const Found found = judge(store->store());
  EXPECT_EQ(found.frames, frames);
  EXPECT_EQ(found.images, frames - 1);
  EXPECT_EQ(found.damaged_images, 1);
  EXPECT_EQ(found.settings, 5);
  EXPECT_LT(found.strips, strips);
  EXPECT_GT(found.strips, strips - 400) << "more is gone than a page holds";
  // The other chunks of the image are there.
  Bytes chunk(blob_chunk_bytes);
  const Bytes image = image_of(30);
  int readable = 0;
  for (std::size_t at = 0; at + chunk.size() <= image.size(); at += chunk.size()) {
    if (!read_blob<FrameRecord>(store->store(), "image", 30, at, chunk).ok()) continue;
    ++readable;
    EXPECT_TRUE(std::equal(chunk.begin(), chunk.end(), image.begin() + static_cast<std::ptrdiff_t>(at)));
  }
  EXPECT_GE(readable, 1);
  const auto lost = store->start().salvaged[static_cast<std::size_t>(RecordType::strip)].lost;
  EXPECT_EQ(lost, strips - found.strips);
  std::map<std::uint16_t, EventRecord> reported;
  for (const EventRecord& event : test::records_of<EventRecord>(store->store())) reported[event.code] = event;
  const EventRecord& of_records = reported[static_cast<std::uint16_t>(StatusCode::records_lost)];
  EXPECT_EQ(of_records.a, lost);
  EXPECT_EQ(of_records.b, static_cast<std::int64_t>(RecordType::strip));
  const EventRecord& of_blobs = reported[static_cast<std::uint16_t>(StatusCode::blobs_damaged)];
  EXPECT_EQ(of_blobs.a, 1);
  EXPECT_EQ(of_blobs.b, static_cast<std::int64_t>(RecordType::frame));
  // Numbers of what was lost must not come again.
  IdentityRecord identity;
  EXPECT_STATUS(get(store->store(), 1, identity), not_found);
  store->close();

  const auto next_store_epoch = make();
  ASSERT_OK(next_store_epoch->open(path_.c_str(), StoreTrouble::refuse, mission_)) << "damage was opened again";
  EXPECT_OK(next_store_epoch->updates());
  next_store_epoch->close();
  EXPECT_FALSE(fs::exists(path_ + "-guard"));
}

TEST_F(SalvageTest, DamageThatKeepsAStartFromSucceedingIsNotOpenedAgain) {
  fly();
  damage();
  {
    const auto store = make();
    ASSERT_OK(store->open(path_.c_str(), StoreTrouble::fly_on, mission_));
    static_cast<void>(test::records_of<StripRecord>(store->store()));
    // The start fails here, and the test does not ask whether the store is damaged.
  }
  const auto store = make();
  ASSERT_OK(store->open(path_.c_str(), StoreTrouble::fly_on, mission_));
  EXPECT_STATUS(store->updates(), store_salvaged);
}

TEST_F(SalvageTest, NothingIsLostWhereOnlyWhatNobodyNeedsIsDamaged) {
  fly();
  const auto noted = make();
  ASSERT_OK(noted->open(path_.c_str(), StoreTrouble::fly_on, mission_));
  noted->close();
  std::ofstream(path_ + "-guard") << "damaged";
  const auto store = make();
  ASSERT_OK(store->open(path_.c_str(), StoreTrouble::fly_on, mission_));
  EXPECT_STATUS(store->updates(), store_salvaged);
  EXPECT_EQ(store->updates().a, frames + strips + 5 + 5 + 1);
  const Found found = judge(store->store());
  EXPECT_EQ(found.images, frames);
  EXPECT_EQ(found.strips, strips);
  IdentityRecord identity;
  ASSERT_OK(get(store->store(), 1, identity));
  EXPECT_EQ(identity.life, 3);
}

TEST_F(SalvageTest, WithoutItsFirstPagesTheRestIsSavedAllTheSame) {
  fly();
  destroy(1);
  destroy(2);
  EXPECT_STATUS(make()->open(path_.c_str(), StoreTrouble::refuse, mission_), store_damaged);
  const auto store = make();
  ASSERT_OK(store->open(path_.c_str(), StoreTrouble::fly_on, mission_));
  EXPECT_STATUS(store->updates(), store_salvaged);
  const Found found = judge(store->store());
  EXPECT_GE(found.images + found.strips, frames) << "both tables were lost with the schema";
  EXPECT_EQ(found.settings, 5);
}

TEST_F(SalvageTest, WithoutOneOfItsTablesItIsReplaced) {
  fly();
  ASSERT_EQ(register_checked_vfs(), SQLITE_OK);
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open_v2(path_.c_str(), &database, SQLITE_OPEN_READWRITE, checked_vfs), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(database, "DROP TABLE strip", nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(database);
  std::ofstream(path_ + "-guard") << "damaged";
  const auto store = make();
  ASSERT_OK(store->open(path_.c_str(), StoreTrouble::fly_on, mission_));
  EXPECT_STATUS(store->updates(), store_set_aside);
  EXPECT_TRUE(fs::exists(path_ + ".aside-1"));
}

TEST_F(SalvageTest, CutOffAnywhereItIsBegunAgainOrGoneOnWith) {
  fly();
  damage();
  std::ofstream(path_ + "-guard") << "damaged";
  const fs::path kept = folder_ / "kept.db";
  fs::copy_file(path_, kept);
  std::set<std::string> seen;
  bool finished = false;
  int call = 1;
  for (int round = 0; round < 60 && !finished; ++round) {
    for (const fs::directory_entry& entry : fs::directory_iterator(fs::path(path_).parent_path())) {
      if (entry.path() != kept) fs::remove_all(entry.path());
    }
    fs::copy_file(kept, path_);
    std::ofstream(path_ + "-guard") << "damaged";
    finished = !test::cut_in_call(folder_.path().string(), call,
                                  [&] { (void)make()->open(path_.c_str(), StoreTrouble::fly_on, mission_); });
    call += 1 + call / 8;
    std::string state;
    for (const char* suffix : {"", ".salvage", ".saved", ".aside-1"}) state += fs::exists(path_ + suffix) ? '1' : '0';
    seen.insert(state);
    const auto store = make();
    ASSERT_OK(store->open(path_.c_str(), StoreTrouble::fly_on, mission_)) << round;
    const Found found = judge(store->store());
    EXPECT_EQ(found.images, frames - 1) << "round " << round << " state " << state;
    EXPECT_GT(found.strips, strips - 400);
    EXPECT_TRUE(fs::exists(path_ + ".aside-1"));
    EXPECT_FALSE(fs::exists(path_ + ".saved"));
    EXPECT_FALSE(fs::exists(path_ + ".salvage"));
  }
  EXPECT_TRUE(finished);
  EXPECT_GT(seen.size(), 1U) << "always cut at the same place";
}

TEST_F(SalvageTest, EachStepBehindACompleteSalvageIsGoneOnWith) {
  fly();
  damage();
  const std::string damaged = test::text_of(path_);
  std::ofstream(path_ + "-guard") << "damaged";
  {
    const auto store = make();
    ASSERT_OK(store->open(path_.c_str(), StoreTrouble::fly_on, mission_));
    store->close();
  }
  const std::string saved = test::text_of(path_);
  // Complete, and the damaged one still in its place; without its log; and quarantined already.
  for (int step = 0; step < 3; ++step) {
    for (const char* suffix : {".aside-1", ".aside-1-wal", "-wal", "-shm", "-sync"}) fs::remove(path_ + suffix);
    std::ofstream(path_ + (step < 2 ? "" : ".aside-1"), std::ios::binary | std::ios::trunc) << damaged;
    if (step == 1) std::ofstream(path_ + ".aside-1-wal") << "the log of the damaged one";
    if (step == 2) fs::remove(path_);
    std::ofstream(path_ + ".saved", std::ios::binary) << saved;
    std::ofstream(path_ + "-guard") << "damaged";
    const auto store = make();
    ASSERT_OK(store->open(path_.c_str(), StoreTrouble::refuse, mission_)) << step;
    EXPECT_EQ(judge(store->store()).images, frames - 1);
    EXPECT_TRUE(test::text_of(path_ + ".aside-1") == damaged);
    if (step == 1) {
      EXPECT_EQ(test::text_of(path_ + ".aside-1-wal"), "the log of the damaged one");
    }
    store->close();
  }
}

TEST_F(SalvageTest, WhereThereIsTooLittleRoomImagesAreWhatIsLeftOut) {
  fly();
  const std::string small = folder_ / "small.db";
  static std::uint8_t scratch[16 * blob_chunk_bytes];
  SalvageCounts counts;
  ASSERT_OK(salvage(path_.c_str(), small.c_str(), 700'000, scratch, counts));
  EXPECT_GT(counts[static_cast<std::size_t>(RecordType::frame)].lost, 0);
  EXPECT_EQ(counts[static_cast<std::size_t>(RecordType::strip)].saved, strips);
  SqliteStore store;
  ASSERT_OK(store.open(small.c_str()));
  const Found found = judge(store);
  EXPECT_EQ(found.strips, strips);
  EXPECT_EQ(found.settings, 5);
  EXPECT_EQ(found.images, counts[static_cast<std::size_t>(RecordType::frame)].saved);
}

TEST_F(SalvageTest, AFlightHasItsDatabaseToItself) {
  fly();
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const auto store = make();
    const char ok = store->open(path_.c_str(), StoreTrouble::fly_on, mission_).ok() ? 'y' : 'n';
    if (write(ready[1], &ok, 1) != 1) _exit(1);
    pause();
    _exit(0);
  }
  char ok = 0;
  ASSERT_EQ(read(ready[0], &ok, 1), 1);
  EXPECT_EQ(ok, 'y');
  const std::string before = test::text_of(path_);
  EXPECT_STATUS(make()->open(path_.c_str(), StoreTrouble::refuse, mission_), store_in_use);
  EXPECT_STATUS(make()->open(path_.c_str(), StoreTrouble::fly_on, mission_), store_in_use);
  EXPECT_TRUE(test::text_of(path_) == before);
  // Tools that read are not in the way.
  SqliteStore tool;
  EXPECT_OK(tool.open_read_only(path_.c_str()));
  tool.close();
  std::thread killer([child] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    kill(child, SIGKILL);
  });
  const auto store = make();
  const Status opened = store->open(path_.c_str(), StoreTrouble::refuse, mission_);
  killer.join();
  waitpid(child, nullptr, 0);
  ASSERT_OK(opened) << "a process that has just been killed locks nobody out";
  EXPECT_EQ(judge(store->store()).images, frames);
}

TEST(Quarantine, TheLogGoesBeforeTheDatabaseAndAnInterruptedOneIsGoneOnWith) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "flight.db";
  std::ofstream(path) << "database";
  std::ofstream(path + "-wal") << "log";
  // What cannot be replaced by a file.
  fs::create_directories(path + ".aside-1-wal/x");
  std::int64_t number = 0;
  EXPECT_STATUS(quarantine_database(path.c_str(), number), io_error);
  EXPECT_TRUE(fs::exists(path)) << "a database without its log would be opened as if nothing were missing";
  EXPECT_TRUE(fs::exists(path + "-wal"));
  fs::remove_all(path + ".aside-1-wal");
  // Cut off after the log was renamed.
  fs::rename(path + "-wal", path + ".aside-1-wal");
  ASSERT_OK(quarantine_database(path.c_str(), number));
  EXPECT_EQ(number, 1);
  EXPECT_EQ(test::text_of(path + ".aside-1"), "database");
  EXPECT_EQ(test::text_of(path + ".aside-1-wal"), "log");
}

}  // namespace
}  // namespace ilp
