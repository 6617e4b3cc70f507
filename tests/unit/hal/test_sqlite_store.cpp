// What the store on a disk promises beyond the contract: its schema, other processes, damage, full disks, power cuts.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "fsw/base/text.hpp"
#include "hal/store/sqlite/page_checksum.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"
#include "tests/unit/hal/expect_status.hpp"
#include "tests/unit/hal/failing_disk.hpp"
#include "tests/unit/hal/small_disk.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {

using Bytes = std::vector<std::uint8_t>;

std::string content_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A database as a user's own tools see it.
class PlainDatabase {
 public:
  explicit PlainDatabase(const std::string& path) { EXPECT_EQ(sqlite3_open(path.c_str(), &database_), SQLITE_OK); }
  ~PlainDatabase() { sqlite3_close(database_); }
  PlainDatabase(const PlainDatabase&) = delete;
  PlainDatabase& operator=(const PlainDatabase&) = delete;

  /// All values of all rows, each followed by `|`.
  std::string query(const std::string& sql) {
    std::string text;
    const auto append = [](void* to, int columns, char** values, char**) {
      for (int i = 0; i < columns; ++i)
        *static_cast<std::string*>(to) += std::string(values[i] ? values[i] : "NULL") + "|";
      return 0;
    };
    char* error = nullptr;
    EXPECT_EQ(sqlite3_exec(database_, sql.c_str(), append, &text, &error), SQLITE_OK) << (error ? error : "");
    sqlite3_free(error);
    return text;
  }

 private:
  sqlite3* database_ = nullptr;
};

FrameRecord frame_of(std::int64_t id, std::uint32_t image_bytes = 0) {
  FrameRecord frame{.id = id};
  frame.image.bytes = image_bytes;
  return frame;
}

Status put_now(Store& store, const FrameRecord& frame, std::uint8_t value) {
  Transaction transaction(store);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(store, frame));
  if (frame.image.bytes != 0)
    ILP_TRY(write_blob<FrameRecord>(store, "image", frame.id, 0, Bytes(frame.image.bytes, value)));
  return transaction.commit();
}

class SqliteStoreTest : public testing::Test {
 protected:
  test::TemporaryFolder folder_;
  std::string path_ = folder_ / "flight.db";
};

TEST_F(SqliteStoreTest, KeepsWhatWasCommittedOverClosing) {
  {
    SqliteStore store;
    ASSERT_OK(store.open(path_.c_str()));
    ASSERT_OK(put_now(store, frame_of(3, 5000), 7));
    ASSERT_OK(store.begin());
    ASSERT_OK(put(store, frame_of(4)));
  }
  SqliteStore store;
  ASSERT_OK(store.open(path_.c_str()));
  FrameRecord frame;
  ASSERT_OK(get(store, 3, frame));
  Bytes image(5000);
  ASSERT_OK(read_blob<FrameRecord>(store, "image", 3, 0, image));
  EXPECT_EQ(image, Bytes(5000, 7));
  EXPECT_STATUS(get(store, 4, frame), not_found);
}

TEST_F(SqliteStoreTest, TablesAreWhatTheInterfaceDocumentSays) {
  SqliteStore store;
  ASSERT_OK(store.open(path_.c_str()));
  ASSERT_OK(store.begin());
  PoseRecord pose{.id = 2};
  pose.centre[1] = 2.5;
  pose.state = PoseState::final;
  ASSERT_OK(put(store, pose));
  KeyframeRecord keyframe{.id = 9, .index = 4};
  ASSERT_OK(put(store, keyframe));
  FrameRecord frame = frame_of(1, 3);
  copy_text(frame.name, "a.png");
  ASSERT_OK(put(store, frame));
  ASSERT_OK(write_blob<FrameRecord>(store, "image", 1, 0, Bytes{1, 2, 255}));
  ASSERT_OK(store.commit());

  PlainDatabase plain(path_);
  EXPECT_EQ(plain.query("SELECT q_cam_from_world_0, q_cam_from_world_3, centre_1, state FROM pose WHERE id=2"),
            "1.0|0.0|2.5|1|");
  EXPECT_EQ(plain.query("SELECT \"index\" FROM keyframe WHERE id=9"), "4|");
  EXPECT_EQ(plain.query("SELECT name, altitude, image_bytes FROM frame"), "a.png|NULL|3|");
  EXPECT_EQ(plain.query("SELECT hex(data) FROM frame_image WHERE id=1"), "0102FF|");
  EXPECT_EQ(plain.query("SELECT type FROM pragma_table_info('depth') WHERE name IN ('id','offset','cells_bytes')"),
            "INTEGER|REAL|INTEGER|");
  EXPECT_EQ(plain.query("PRAGMA journal_mode"), "wal|");
  EXPECT_EQ(plain.query("PRAGMA page_size"), "4096|");
  EXPECT_EQ(plain.query("PRAGMA auto_vacuum"), "0|");
  EXPECT_EQ(plain.query("PRAGMA integrity_check"), "ok|");
}

TEST_F(SqliteStoreTest, AnotherVersionIsRefusedAndLeftUntouched) {
  const std::string versions[] = {"PRAGMA user_version=1; CREATE TABLE frame(id INTEGER PRIMARY KEY, other TEXT)",
                                  "CREATE TABLE mail(id INTEGER)", "PRAGMA user_version=77"};
  for (const std::string& sql : versions) {
    std::filesystem::remove(path_);
    PlainDatabase(path_).query(sql);
    const std::string before = content_of(path_);
    SqliteStore store;
    EXPECT_STATUS(store.open(path_.c_str()), store_schema) << sql;
    EXPECT_STATUS(store.open_read_only(path_.c_str()), store_schema) << sql;
    EXPECT_STATUS(store.begin(), invalid_argument);
    EXPECT_EQ(content_of(path_), before) << sql;
    EXPECT_FALSE(std::filesystem::exists(path_ + "-wal"));
  }
}

TEST_F(SqliteStoreTest, ClosedStoreAnswersEveryCall) {
  SqliteStore store;
  FrameRecord frame;
  std::int64_t records = 0;
  RecordMask changed = 0;
  Bytes byte(1);
  EXPECT_FALSE(store.begin().ok());
  EXPECT_FALSE(put(store, frame).ok());
  EXPECT_FALSE(get(store, 1, frame).ok());
  EXPECT_FALSE(next(store, 1, frame).ok());
  EXPECT_FALSE(last(store, frame).ok());
  EXPECT_FALSE(store.erase(record_info<FrameRecord>(), 1).ok());
  EXPECT_FALSE(store.count(record_info<FrameRecord>(), records).ok());
  EXPECT_FALSE(write_blob<FrameRecord>(store, "image", 1, 0, byte).ok());
  EXPECT_FALSE(read_blob<FrameRecord>(store, "image", 1, 0, byte).ok());
  EXPECT_FALSE(store.poll(changed).ok());
  EXPECT_EQ(store.usage().bytes, 0);
  store.rollback();
  EXPECT_FALSE(store.open((folder_ / "no/such/folder/x.db").c_str()).ok());
}

TEST_F(SqliteStoreTest, PollSeesTheWritesOfAnotherConnection) {
  SqliteStore here;
  SqliteStore there;
  ASSERT_OK(here.open(path_.c_str()));
  ASSERT_OK(there.open(path_.c_str()));
  RecordMask changed = 0;
  ASSERT_OK(here.poll(changed));
  ASSERT_OK(here.poll(changed));
  EXPECT_EQ(changed, 0U);
  ASSERT_OK(put_now(there, frame_of(1), 0));
  ASSERT_OK(here.poll(changed));
  EXPECT_EQ(changed & mask_of(RecordType::frame), mask_of(RecordType::frame));
  ASSERT_OK(here.poll(changed));
  EXPECT_EQ(changed, 0U);
  FrameRecord frame;
  EXPECT_OK(get(here, 1, frame));
}

TEST_F(SqliteStoreTest, ATransactionWaitsForThatOfAnotherProcess) {
  SqliteStore store;
  ASSERT_OK(store.open(path_.c_str()));
  int begun[2];
  ASSERT_EQ(pipe(begun), 0);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    SqliteStore other;
    if (!other.open(path_.c_str()).ok() || !other.begin().ok() || !put(other, frame_of(1)).ok()) _exit(1);
    if (write(begun[1], "!", 1) != 1) _exit(2);
    usleep(200'000);
    _exit(other.commit().ok() ? 0 : 3);
  }
  char word = 0;
  ASSERT_EQ(read(begun[0], &word, 1), 1);
  EXPECT_OK(put_now(store, frame_of(2), 0));
  FrameRecord frame;
  EXPECT_OK(get(store, 1, frame)) << "the transaction did not wait";
  int how = 0;
  waitpid(child, &how, 0);
  EXPECT_TRUE(WIFEXITED(how) && WEXITSTATUS(how) == 0) << how;
  close(begun[0]);
  close(begun[1]);
}

TEST_F(SqliteStoreTest, ALockThatIsNeverReleasedIsAStatus) {
  SqliteStore store;
  SqliteStore hung;
  ASSERT_OK(store.open(path_.c_str()));
  ASSERT_OK(hung.open(path_.c_str()));
  ASSERT_OK(hung.begin());
  ASSERT_OK(put(hung, frame_of(1)));
  const auto begun = std::chrono::steady_clock::now();
  EXPECT_STATUS(put_now(store, frame_of(2), 0), store_locked);
  EXPECT_GE(std::chrono::steady_clock::now() - begun, std::chrono::seconds(2)) << "others have two seconds to end";
  ASSERT_OK(hung.commit());
  EXPECT_OK(put_now(store, frame_of(2), 0));
}

TEST_F(SqliteStoreTest, OnlyTheFirstTransactionWaitsForALockThatIsKept) {
  SqliteStore store;
  SqliteStore hung;
  ASSERT_OK(store.open(path_.c_str()));
  ASSERT_OK(hung.open(path_.c_str()));
  ASSERT_OK(hung.begin());
  sqlite::wait_for_writers(store.session(), 50);
  EXPECT_EQ(sqlite::locked_ms(store.session()), 0);
  // Each of them waiting would take longer than the test may.
  for (int i = 0; i < 20'000; ++i) ASSERT_EQ(store.begin().code, StatusCode::store_locked);
  EXPECT_GE(sqlite::locked_ms(store.session()), 50);
  FrameRecord frame;
  EXPECT_STATUS(get(store, 1, frame), not_found) << "reading goes on";
  ASSERT_OK(put(hung, frame_of(1)));
  ASSERT_OK(hung.commit());
  EXPECT_OK(put_now(store, frame_of(2), 0));
  EXPECT_OK(get(store, 1, frame));
  EXPECT_EQ(sqlite::locked_ms(store.session()), 0);
}

TEST_F(SqliteStoreTest, TheHolderOfTheLockIsFound) {
  SqliteStore store;
  ASSERT_OK(store.open(path_.c_str()));
  EXPECT_EQ(sqlite::lock_holder(store.session()), 0);
  int begun[2], over[2];
  ASSERT_TRUE(pipe(begun) == 0 && pipe(over) == 0);
  const pid_t child = fork();
  if (child == 0) {
    SqliteStore other;
    if (!other.open(path_.c_str()).ok() || !other.begin().ok() || write(begun[1], "!", 1) != 1) _exit(1);
    char word = 0;
    _exit(read(over[0], &word, 1) == 1 ? 0 : 2);
  }
  char word = 0;
  ASSERT_EQ(read(begun[0], &word, 1), 1);
  EXPECT_EQ(sqlite::lock_holder(store.session()), child);
  ASSERT_EQ(write(over[1], "!", 1), 1);
  int how = 0;
  waitpid(child, &how, 0);
  EXPECT_TRUE(WIFEXITED(how) && WEXITSTATUS(how) == 0) << how;
  EXPECT_EQ(sqlite::lock_holder(store.session()), 0);
  // Looking has not cost this process its own locks.
  ASSERT_OK(store.begin());
  const pid_t rival = fork();
  if (rival == 0) {
    SqliteStore other;
    if (!other.open(path_.c_str()).ok()) _exit(1);
    sqlite::wait_for_writers(other.session(), 1);
    _exit(other.begin().is(StatusCode::store_locked) && sqlite::lock_holder(other.session()) == getppid() ? 0 : 2);
  }
  waitpid(rival, &how, 0);
  EXPECT_TRUE(WIFEXITED(how) && WEXITSTATUS(how) == 0) << how;
  for (const int end : {begun[0], begun[1], over[0], over[1]}) close(end);
}

TEST_F(SqliteStoreTest, ReadOnlyStoreReadsDuringTheFlightAndRefusesWrites) {
  SqliteStore reader;
  EXPECT_STATUS(reader.open_read_only(path_.c_str()), store_error);
  EXPECT_FALSE(std::filesystem::exists(path_)) << "reading must not create a database";
  SqliteStore flight;
  ASSERT_OK(flight.open(path_.c_str()));
  ASSERT_OK(put_now(flight, frame_of(1, 4), 5));
  ASSERT_OK(reader.open_read_only(path_.c_str()));
  Bytes image(4);
  ASSERT_OK(read_blob<FrameRecord>(reader, "image", 1, 0, image));
  EXPECT_EQ(image, Bytes(4, 5));
  EXPECT_FALSE(put_now(reader, frame_of(2), 0).ok());
  ASSERT_OK(put_now(flight, frame_of(3), 0));
  FrameRecord frame;
  EXPECT_OK(get(reader, 3, frame));
  EXPECT_STATUS(get(reader, 2, frame), not_found);
}

TEST_F(SqliteStoreTest, ReadingAFinishedFlightLeavesNothingBeside) {
  const std::string path = folder_ / "a flight #3? 100%.db";
  SqliteStore flight;
  ASSERT_OK(flight.open(path.c_str()));
  ASSERT_OK(put_now(flight, frame_of(1, 4), 5));
  flight.close();
  const std::string before = content_of(path);
  SqliteStore reader;
  ASSERT_OK(reader.open_read_only(path.c_str()));
  Bytes image(4);
  ASSERT_OK(read_blob<FrameRecord>(reader, "image", 1, 0, image));
  EXPECT_EQ(image, Bytes(4, 5));
  EXPECT_FALSE(put_now(reader, frame_of(2), 0).ok());
  EXPECT_FALSE(std::filesystem::exists(path + "-wal"));
  EXPECT_FALSE(std::filesystem::exists(path + "-shm"));
  reader.close();
  EXPECT_FALSE(std::filesystem::exists(path + "-wal"));
  EXPECT_FALSE(std::filesystem::exists(path + "-shm"));
  EXPECT_EQ(content_of(path), before);
}

TEST_F(SqliteStoreTest, ALimitedDatabaseIsFullButErasesAndTakesAgain) {
  constexpr std::int64_t limit = 4 << 20;
  SqliteStore store;
  EXPECT_STATUS(store.limit(limit), invalid_argument);
  ASSERT_OK(store.open(path_.c_str()));
  EXPECT_STATUS(store.limit(0), invalid_argument);
  ASSERT_OK(store.limit(limit));
  std::int64_t id = 0;
  Status status;
  while (status.ok() && id < 100) {
    ++id;
    status = put_now(store, frame_of(id, 100'000), static_cast<std::uint8_t>(id));
  }
  EXPECT_TRUE(status.is(StatusCode::store_full)) << status_name(status.code);
  EXPECT_EQ(status.b, limit);
  EXPECT_GT(id, 30) << "most of the limit is for the flight";
  for (int again = 0; again < 3; ++again) {
    ASSERT_OK(store.begin());
    ASSERT_OK(store.erase(record_info<FrameRecord>(), 1 + again));
    ASSERT_OK(store.commit());
    ASSERT_OK(put_now(store, frame_of(1000 + again, 100'000), 7));
    EXPECT_STATUS(put_now(store, frame_of(2000, 100'000), 8), store_full);
  }
  Bytes image(100'000);
  ASSERT_OK(read_blob<FrameRecord>(store, "image", 10, 0, image));
  EXPECT_EQ(image, Bytes(100'000, 10));
  store.close();
  EXPECT_LE(std::filesystem::file_size(path_), static_cast<std::uintmax_t>(limit));
  EXPECT_EQ(PlainDatabase(path_).query("PRAGMA integrity_check"), "ok|");
}

TEST_F(SqliteStoreTest, PagesAreUsedAgainAndTheLogStaysShort) {
  SqliteStore store;
  ASSERT_OK(store.open(path_.c_str()));
  constexpr std::int64_t held = 50;
  std::uintmax_t after_first_round = 0;
  std::uintmax_t longest_log = 0;
  for (std::int64_t id = 1; id <= 20 * held; ++id) {
    ASSERT_OK(store.begin());
    ASSERT_OK(put(store, frame_of(id, static_cast<std::uint32_t>(20'000 + 97 * (id % 40)))));
    if (id > held) {
      ASSERT_OK(store.erase(record_info<FrameRecord>(), id - held));
    }
    ASSERT_OK(store.commit());
    longest_log = std::max(longest_log, std::filesystem::file_size(path_ + "-wal"));
    if (id == 2 * held) after_first_round = static_cast<std::uintmax_t>(store.usage().bytes);
  }
  EXPECT_LE(static_cast<std::uintmax_t>(store.usage().bytes), after_first_round + 100'000);
  EXPECT_LE(longest_log, static_cast<std::uintmax_t>(sqlite_log_bytes));
  store.close();
  EXPECT_FALSE(std::filesystem::exists(path_ + "-wal"));
}

TEST_F(SqliteStoreTest, ADiskThatIsReallyFullLosesNothingAndIsUsedAgainWhenThereIsRoom) {
  const test::SmallDisk disk(folder_ / "disk", 6);
  if (!disk.mounted()) GTEST_SKIP() << "no right to mount a small disk here";
  const std::string path = disk.path() + "/flight.db";
  SqliteStore store;
  ASSERT_OK(store.open(path.c_str()));
  std::int64_t id = 0;
  Status status;
  while (status.ok() && id < 200) {
    ++id;
    status = put_now(store, frame_of(id, 100'000), static_cast<std::uint8_t>(id));
  }
  EXPECT_TRUE(status.is(StatusCode::store_full)) << status_name(status.code) << " " << status.a << " " << status.b;
  ASSERT_GT(id, 10);
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(put_now(store, frame_of(500 + i, 1'000'000), 1).ok());
  Bytes image(100'000);
  for (std::int64_t held = 1; held < id; ++held) {
    ASSERT_OK(read_blob<FrameRecord>(store, "image", held, 0, image));
    ASSERT_EQ(image, Bytes(100'000, static_cast<std::uint8_t>(held)));
  }
  ASSERT_TRUE(disk.resize(16));
  EXPECT_OK(put_now(store, frame_of(900, 100'000), 9));
  store.close();
  EXPECT_EQ(PlainDatabase(path).query("PRAGMA integrity_check"), "ok|");
}

TEST_F(SqliteStoreTest, ADiskForReadingOnlyIsRefusedAtTheStartAndAStatusInFlight) {
  test::SmallDisk disk(folder_ / "disk", 8);
  if (!disk.mounted()) GTEST_SKIP() << "no right to mount a small disk here";
  const std::string path = disk.path() + "/flight.db";
  {
    SqliteStore store;
    ASSERT_OK(store.open(path.c_str()));
    ASSERT_OK(put_now(store, frame_of(1, 1000), 3));
  }
  ASSERT_TRUE(disk.set_read_only(true));
  SqliteStore store;
  EXPECT_STATUS(store.open(path.c_str()), store_error);
  EXPECT_STATUS(store.open((disk.path() + "/none.db").c_str()), store_error);
  SqliteStore reader;
  ASSERT_OK(reader.open_read_only(path.c_str()));
  Bytes image(1000);
  ASSERT_OK(read_blob<FrameRecord>(reader, "image", 1, 0, image));
  EXPECT_EQ(image, Bytes(1000, 3));
  reader.close();
  ASSERT_TRUE(disk.set_read_only(false));
  ASSERT_OK(store.open(path.c_str()));
  EXPECT_OK(put_now(store, frame_of(2), 3));
}

TEST_F(SqliteStoreTest, EveryCommitReachesTheDisk) {
  test::FailingDisk disk;
  SqliteStore store;
  ASSERT_OK(store.open(path_.c_str()));
  for (std::int64_t id = 1; id <= 10; ++id) {
    const int before = disk.syncs();
    ASSERT_OK(put_now(store, frame_of(id), 0));
    EXPECT_GT(disk.syncs(), before) << "a commit that a power cut would undo";
  }
}

TEST_F(SqliteStoreTest, WhileACommitIsSynchronisedBehindItTheOthersMayWrite) {
  test::FailingDisk disk;
  SqliteStore store, other;
  ASSERT_OK(store.open(path_.c_str()));
  ASSERT_OK(store.synchronise(Synchronise::behind_commit));
  ASSERT_OK(other.open(path_.c_str()));
  ASSERT_OK(other.synchronise(Synchronise::later));
  // The first commit begins the log, whose header SQLite synchronises at once.
  ASSERT_OK(put_now(store, frame_of(1), 0));
  int written = 0;
  disk.during_next_sync([&] {
    EXPECT_OK(put_now(other, frame_of(3), 0)) << "the lock is held";
    ++written;
  });
  const int before = disk.syncs();
  ASSERT_OK(put_now(store, frame_of(2), 0));
  EXPECT_EQ(written, 1);
  EXPECT_EQ(disk.syncs(), before + 1);
}

TEST_F(SqliteStoreTest, FlushSynchronisesWhatAnyProcessHasCommittedAndNothingTwice) {
  test::FailingDisk disk;
  SqliteStore store, other;
  ASSERT_OK(store.open(path_.c_str()));
  ASSERT_OK(store.synchronise(Synchronise::later));
  ASSERT_OK(other.open(path_.c_str()));
  ASSERT_OK(other.synchronise(Synchronise::later));
  ASSERT_OK(put_now(store, frame_of(1), 0));
  ASSERT_OK(store.flush());
  int before = disk.syncs();
  ASSERT_OK(put_now(store, frame_of(2), 0));
  EXPECT_EQ(disk.syncs(), before) << "the commit should not wait for the disk";
  ASSERT_OK(store.flush());
  EXPECT_EQ(disk.syncs(), before + 1);
  ASSERT_OK(store.flush());
  EXPECT_EQ(disk.syncs(), before + 1) << "there is nothing new";
  ASSERT_OK(put_now(other, frame_of(3), 0));
  // Also in the middle of a transaction, as the downlink does it.
  ASSERT_OK(store.begin());
  ASSERT_OK(store.flush());
  EXPECT_EQ(disk.syncs(), before + 2) << "the other's commit is not on the disk";
  ASSERT_OK(store.commit());
  before = disk.syncs();
  ASSERT_OK(store.begin());
  ASSERT_OK(store.commit());
  EXPECT_EQ(disk.syncs(), before) << "a transaction without writes";
}

TEST_F(SqliteStoreTest, ADiskThatRefusesToSynchroniseIsToldByFlushUntilEverythingIsWrittenAnew) {
  test::FailingDisk disk;
  SqliteStore store;
  ASSERT_OK(store.open(path_.c_str()));
  ASSERT_OK(store.synchronise(Synchronise::behind_commit));
  ASSERT_OK(put_now(store, frame_of(1), 0));
  disk.fail_syncs(SQLITE_IOERR_FSYNC);
  EXPECT_OK(put_now(store, frame_of(2), 0)) << "it is done, only not on the disk";
  EXPECT_STATUS(store.flush(), store_error);
  disk.fail_syncs(SQLITE_OK);
  ASSERT_OK(store.flush());
  // The pages that were not synchronised in the log are in the database now.
  const std::string database = content_of(path_);
  store.close();
  std::ofstream(folder_ / "copy.db", std::ios::binary) << database;
  FrameRecord frame;
  ASSERT_OK(store.open((folder_ / "copy.db").c_str()));
  EXPECT_OK(get(store, 2, frame));
}

TEST_F(SqliteStoreTest, FullOrBrokenDiskLeavesWhatWasCommitted) {
  for (const int code : {SQLITE_FULL, SQLITE_IOERR_WRITE}) {
    bool failed = true;
    for (int nth = 1; failed; ++nth) {
      ASSERT_LT(nth, 1000);
      for (const char* suffix : {"", "-wal", "-shm"}) std::filesystem::remove(path_ + suffix);
      test::FailingDisk disk;
      {
        SqliteStore store;
        ASSERT_OK(store.open(path_.c_str()));
        ASSERT_OK(put_now(store, frame_of(1, 20000), 1));
        disk.fail_from(nth, code);
        const Status status = put_now(store, frame_of(2, 50000), 2);
        failed = disk.failed();
        const StatusCode expected = code == SQLITE_FULL ? StatusCode::store_full : StatusCode::store_error;
        EXPECT_EQ(status.code, failed ? expected : StatusCode::ok) << "write " << nth;
        disk.fail_from(0, 0);
        // The disk has room again: the flight goes on.
        EXPECT_OK(put_now(store, frame_of(3, 10), 3)) << "write " << nth;
      }
      SqliteStore store;
      ASSERT_OK(store.open(path_.c_str()));
      FrameRecord frame;
      Bytes image(20000);
      ASSERT_OK(read_blob<FrameRecord>(store, "image", 1, 0, image));
      EXPECT_EQ(image, Bytes(20000, 1));
      EXPECT_EQ(get(store, 2, frame).ok(), !failed) << "write " << nth;
      EXPECT_OK(get(store, 3, frame));
      store.close();
      EXPECT_EQ(PlainDatabase(path_).query("PRAGMA integrity_check"), "ok|");
    }
  }
}

TEST_F(SqliteStoreTest, AFaultDoomsItsTransaction) {
  test::FailingDisk disk;
  SqliteStore store;
  ASSERT_OK(store.open(path_.c_str()));
  ASSERT_OK(store.begin());
  ASSERT_OK(put(store, frame_of(1)));
  disk.fail_from(1, SQLITE_FULL);
  // Larger than the page cache, so that it has to be written before the commit.
  EXPECT_STATUS(put(store, frame_of(2, 20000000)), store_full);
  disk.fail_from(0, 0);
  EXPECT_FALSE(put(store, frame_of(3)).ok());
  EXPECT_FALSE(store.commit().ok());
  std::int64_t records = -1;
  ASSERT_OK(store.count(record_info<FrameRecord>(), records));
  EXPECT_EQ(records, 0) << "part of a transaction was committed";
  EXPECT_OK(put_now(store, frame_of(4), 0));
}

TEST_F(SqliteStoreTest, DamagedDatabasesAreAnsweredWithAStatus) {
  {
    SqliteStore store;
    ASSERT_OK(store.open(path_.c_str()));
    for (std::int64_t id = 1; id <= 20; ++id) ASSERT_OK(put_now(store, frame_of(id, 3000), 1));
  }
  const std::string whole = content_of(path_);
  const auto use = [&](const std::string& content) {
    std::ofstream(path_, std::ios::binary | std::ios::trunc) << content;
    SqliteStore store;
    Status status = store.open(path_.c_str());
    if (!status.ok()) return status;
    FrameRecord frame;
    Bytes image(3000);
    for (std::int64_t id = 0; next(store, id, frame).ok(); id = frame.id) {
      EXPECT_GT(frame.id, id) << "a walk that might never end";
      static_cast<void>(read_blob<FrameRecord>(store, "image", frame.id, 0, image));
    }
    return put_now(store, frame_of(21, 3000), 1);
  };
  EXPECT_OK(use(whole));
  for (const char* suffix : {"-wal", "-shm"}) std::filesystem::remove(path_ + suffix);
  EXPECT_STATUS(
      use("this is no database, whatever its name says, and longer than a header is: " + std::string(200, 'x')),
      store_damaged);
  EXPECT_FALSE(use(whole.substr(0, whole.size() / 2)).ok());
  unsigned random = 1;
  for (int round = 0; round < 200; ++round) {
    for (const char* suffix : {"-wal", "-shm"}) std::filesystem::remove(path_ + suffix);
    std::string damaged = whole;
    for (int i = 0; i < 20; ++i) {
      random = random * 1664525U + 1013904223U;
      damaged[random % damaged.size()] = static_cast<char>(random >> 24U);
    }
    static_cast<void>(use(damaged));  // any Status will do, but no crash
  }
}

TEST_F(SqliteStoreTest, WalkThroughADamagedIndexEnds) {
  {
    SqliteStore store;
    ASSERT_OK(store.open(path_.c_str()));
    ASSERT_OK(store.begin());
    for (std::int64_t id = 1; id <= 3; ++id) {
      StripRecord strip{.id = id, .first_keyframe_id = 0x11223300 + id};
      ASSERT_OK(put(store, strip));
    }
    ASSERT_OK(store.commit());
  }
  // The third row says that it is the first: seven bytes before its first column stands its row id
  // (https://www.sqlite.org/fileformat2.html, "Record Format").
  std::string content = content_of(path_);
  const std::size_t column = content.find("\x11\x22\x33\x03");
  ASSERT_NE(column, std::string::npos);
  ASSERT_EQ(content[column - 7], 3);
  content[column - 7] = 1;
  // A page that was written so: its own checksum is right.
  const std::size_t page = column / page_bytes;
  seal_page(static_cast<std::uint32_t>(page + 1),
            Page(reinterpret_cast<std::uint8_t*>(content.data()) + page * page_bytes, page_bytes));
  std::ofstream(path_, std::ios::binary | std::ios::trunc) << content;
  SqliteStore store;
  ASSERT_OK(store.open(path_.c_str()));
  StripRecord strip;
  Status status;
  int steps = 0;
  for (std::int64_t id = 0; status.ok() && steps < 100; ++steps) {
    status = next(store, id, strip);
    id = strip.id;
  }
  EXPECT_STATUS(status, store_damaged);
  EXPECT_TRUE(store.damaged());
  EXPECT_LE(steps, 3);
}

/// Transaction n: frame n with an image full of n, strip n, and the checkpoint that says n.
Status fly(Store& store, std::int64_t n) {
  Transaction transaction(store);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(store, frame_of(n, 20000)));
  ILP_TRY(write_blob<FrameRecord>(store, "image", n, 0, Bytes(20000, static_cast<std::uint8_t>(n))));
  StripRecord strip{.id = n};
  ILP_TRY(put(store, strip));
  CheckpointRecord checkpoint{.id = 1, .cursor = n};
  ILP_TRY(put(store, checkpoint));
  return transaction.commit();
}

TEST_F(SqliteStoreTest, ProcessKilledAtAnyMomentLosesNoCommittedTransaction) {
  std::int64_t cursor = 0;
  for (int round = 0; round < 8; ++round) {
    int report[2];
    ASSERT_EQ(pipe(report), 0);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      close(report[0]);
      SqliteStore store;
      if (!store.open(path_.c_str()).ok()) _exit(1);
      for (std::int64_t n = cursor + 1;; ++n) {
        if (!fly(store, n).ok() || write(report[1], &n, sizeof(n)) != sizeof(n)) _exit(2);
      }
    }
    close(report[1]);
    std::int64_t confirmed = 0;
    for (int i = 0; i < 3 + round; ++i) ASSERT_EQ(read(report[0], &confirmed, sizeof(confirmed)), 8);
    usleep(static_cast<useconds_t>(round * 700));
    kill(child, SIGKILL);
    int how = 0;
    waitpid(child, &how, 0);
    ASSERT_TRUE(WIFSIGNALED(how)) << "the child ended by itself: " << WEXITSTATUS(how);
    while (read(report[0], &confirmed, sizeof(confirmed)) == 8) {
    }
    close(report[0]);

    SqliteStore store;
    ASSERT_OK(store.open(path_.c_str()));
    CheckpointRecord checkpoint;
    ASSERT_OK(get(store, 1, checkpoint));
    cursor = checkpoint.cursor;
    EXPECT_GE(cursor, confirmed) << "a committed transaction was lost";
    FrameRecord frame;
    StripRecord strip;
    ASSERT_OK(last(store, frame));
    ASSERT_OK(last(store, strip));
    EXPECT_EQ(frame.id, cursor) << "part of a transaction is there";
    EXPECT_EQ(strip.id, cursor);
    std::int64_t frames = 0;
    ASSERT_OK(store.count(record_info<FrameRecord>(), frames));
    EXPECT_EQ(frames, cursor);
    Bytes image(20000);
    for (std::int64_t id = 1; id <= cursor; ++id) {
      ASSERT_OK(read_blob<FrameRecord>(store, "image", id, 0, image));
      ASSERT_EQ(image, Bytes(20000, static_cast<std::uint8_t>(id)));
    }
  }
  EXPECT_GT(cursor, 20);
}

}  // namespace
}  // namespace ilp
