// Bits that flip under the store: what it gives out is right, or it says that it is damaged.
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "fsw/records/serial.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "hal/store/scrub.hpp"
#include "hal/store/sqlite/checked_vfs.hpp"
#include "hal/store/sqlite/log_mark.hpp"
#include "hal/store/sqlite/page_checksum.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"
#include "tests/unit/hal/expect_status.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

using Bytes = std::vector<std::uint8_t>;

std::string content_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}
void set_content(const std::string& path, const std::string& content) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << content;
}
void flip(std::string& content, std::size_t bit) {
  content[bit / 8] = static_cast<char>(content[bit / 8] ^ static_cast<char>(1U << bit % 8));
}

/// What a small flight has stored, and the judgement of any store that should hold it.
class Contents {
 public:
  explicit Contents(std::vector<std::uint32_t> images) : images_(std::move(images)) {}

  void fill(Store& store) const {
    for (std::size_t i = 0; i < images_.size(); ++i) {
      Transaction transaction(store);
      ASSERT_OK(transaction.begin());
      const auto id = static_cast<std::int64_t>(i + 1);
      ASSERT_OK(put(store, frame(id)));
      if (images_[i] != 0) {
        ASSERT_OK(write_blob<FrameRecord>(store, "image", id, 0, image(id)));
      }
      ASSERT_OK(put(store, pose(id)));
      ASSERT_OK(transaction.commit());
    }
  }

  /// Every answer is right or says what is wrong. Returns how many said it.
  int judge(Store& store, const std::string& where, bool may_miss = false) const {
    int damaged = 0;
    const auto allowed = [&](const Status& status) {
      if (!status.ok()) ++damaged;
      EXPECT_TRUE(status.ok() || status.is(StatusCode::record_damaged) || status.is(StatusCode::store_damaged) ||
                  (may_miss && status.is(StatusCode::not_found)))
          << where << ": " << status_name(status.code) << " " << status.a << " " << status.b;
      return status.ok();
    };
    const auto count = static_cast<std::int64_t>(images_.size());
    for (std::int64_t id = 1; id <= count; ++id) {
      FrameRecord found;
      if (allowed(get(store, id, found))) expect_same(found, frame(id), where);
      PoseRecord found_pose;
      if (allowed(get(store, id, found_pose))) expect_same(found_pose, pose(id), where);
      const std::uint32_t size = images_[static_cast<std::size_t>(id - 1)];
      if (size == 0) continue;
      Bytes bytes(size);
      if (allowed(read_blob<FrameRecord>(store, "image", id, 0, bytes))) {
        EXPECT_TRUE(bytes == image(id)) << where;
      }
      Bytes chunk(size / 3);
      if (allowed(read_blob<FrameRecord>(store, "image", id, size / 2, chunk))) {
        EXPECT_TRUE(std::equal(chunk.begin(), chunk.end(), image(id).begin() + size / 2)) << where;
      }
    }
    for (const std::int64_t none : {std::int64_t{0}, count + 1, std::int64_t{-5}}) {
      FrameRecord found;
      EXPECT_FALSE(get(store, none, found).ok()) << where;
    }
    std::set<std::int64_t> seen;
    std::int64_t after = std::numeric_limits<std::int64_t>::min();
    Status status;
    for (int steps = 0; steps < 100; ++steps) {
      FrameRecord found;
      status = next(store, after, found);
      if (!status.ok() && !status.is(StatusCode::record_damaged)) break;
      const std::int64_t id = status.ok() ? found.id : status.a;
      EXPECT_GT(id, after) << where << ": a walk that might never end";
      if (status.ok()) expect_same(found, frame(found.id), where);
      seen.insert(id);
      after = id;
    }
    if (!status.is(StatusCode::not_found)) {
      allowed(status);
    } else if (!may_miss) {
      EXPECT_EQ(static_cast<std::int64_t>(seen.size()), count) << where << ": a record was passed over in silence";
    }
    FrameRecord newest;
    if (allowed(last(store, newest)) && !may_miss) {
      EXPECT_EQ(newest.id, count) << where;
    }
    return damaged;
  }

  FrameRecord frame(std::int64_t id) const {
    FrameRecord record;
    record.id = id;
    record.time_ns = 1'000'000'007 * id;
    record.width = -3;
    record.altitude = id % 2 == 0 ? unknown : 1.0 / static_cast<double>(id);
    std::snprintf(record.name, sizeof(record.name), "frame %d", static_cast<int>(id));
    record.image.bytes = images_[static_cast<std::size_t>(id - 1)];
    return record;
  }
  static PoseRecord pose(std::int64_t id) {
    PoseRecord record{.id = id, .state = PoseState::final};
    record.centre[1] = std::numeric_limits<double>::infinity();
    record.matches = 0xFFFFFFFF;
    record.covariance[20] = static_cast<double>(id);
    return record;
  }
  Bytes image(std::int64_t id) const {
    Bytes bytes(images_[static_cast<std::size_t>(id - 1)]);
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * 31 + i / 256 + 7);
    return bytes;
  }

 private:
  template <typename Record>
  static void expect_same(const Record& is, const Record& should, const std::string& where) {
    const RecordInfo& info = record_info<Record>();
    Bytes a(serial_bytes(info));
    Bytes b(serial_bytes(info));
    ASSERT_OK(serialize(info, &is, a));
    ASSERT_OK(serialize(info, &should, b));
    EXPECT_TRUE(a == b) << where << ": wrong " << info.name << " " << should.id;
  }
  std::vector<std::uint32_t> images_;
};

TEST(RamStoreDamage, WhateverBitFlipsInTheRegionNothingWrongIsGivenOut) {
  std::vector<std::byte> region(40'000);
  RamStore store(region);
  const Contents contents({10, 0, 4100, 300});
  contents.fill(store);
  ASSERT_EQ(contents.judge(store, "undamaged"), 0);
  const std::size_t used = store.memory().high_water + 64;
  ASSERT_LT(used, region.size());
  int noticed = 0;
  for (std::size_t bit = 0; bit < 8 * used; ++bit) {
    const auto mask = static_cast<std::byte>(1U << bit % 8);
    const std::byte before = region[bit / 8];
    region[bit / 8] ^= mask;
    noticed += contents.judge(store, "bit " + std::to_string(bit)) > 0 ? 1 : 0;
    // A bit of the index may have been mended.
    region[bit / 8] = before;
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_GT(noticed, 20'000) << "images and records are most of the region";
  EXPECT_EQ(contents.judge(store, "in the end"), 0);
}

TEST(RamStoreDamage, ADamagedRecordIsReplacedOrErasedAndADamagedChunkWrittenAnewAsAWhole) {
  std::vector<std::byte> region(100'000);
  RamStore store(region);
  const Contents contents({10'000, 10'000});
  contents.fill(store);
  const auto flip_in = [&](const Bytes& pattern) {
    auto* const begin = reinterpret_cast<std::uint8_t*>(region.data());
    auto* const end = begin + region.size();
    int found = 0;
    for (auto* at = std::search(begin, end, pattern.begin(), pattern.end()); at != end; ++found) {
      *at ^= 4;
      at = std::search(at, end, pattern.begin(), pattern.end());
    }
    ASSERT_GT(found, 0);
  };
  flip_in({'f', 'r', 'a', 'm', 'e', ' ', '1'});
  FrameRecord frame;
  const Status found = get(store, 1, frame);
  EXPECT_STATUS(found, record_damaged);
  EXPECT_EQ(found.a, 1);
  EXPECT_EQ(found.b, static_cast<std::int64_t>(RecordType::frame));
  ASSERT_OK(store.begin());
  ASSERT_OK(put(store, contents.frame(1)));
  ASSERT_OK(write_blob<FrameRecord>(store, "image", 1, 0, contents.image(1)));
  ASSERT_OK(store.commit());
  EXPECT_EQ(contents.judge(store, "replaced"), 0);

  const Bytes image = contents.image(2);
  const Bytes pattern(image.begin() + 5000, image.begin() + 5200);
  flip_in(pattern);
  for (const std::int64_t id : {1, 2}) {
    Bytes chunk(blob_chunk_bytes);
    EXPECT_OK(read_blob<FrameRecord>(store, "image", id, 0, chunk));
    EXPECT_STATUS(read_blob<FrameRecord>(store, "image", id, 4096, chunk), record_damaged);
    EXPECT_TRUE(chunk == Bytes(blob_chunk_bytes, 0)) << "damaged bytes were given out";
    ASSERT_OK(store.begin());
    EXPECT_STATUS(write_blob<FrameRecord>(store, "image", id, 4100, Bytes(10)), record_damaged);
    store.rollback();
    ASSERT_OK(store.begin());
    EXPECT_OK(write_blob<FrameRecord>(store, "image", id, 4096, Bytes(image.begin() + 4096, image.begin() + 2 * 4096)));
    ASSERT_OK(store.commit());
  }
  EXPECT_EQ(contents.judge(store, "mended"), 0);
}

/// A database on a disk as the flight left it, valid.
class SqliteDamage : public testing::Test {
 protected:
  void fill(const Contents& contents) {
    SqliteStore store;
    ASSERT_OK(store.open(path_.c_str()));
    contents.fill(store);
  }
  /// As a tool that knows of the pages' checksums, but not of those of records, would.
  void change(const std::string& sql) {
    ASSERT_EQ(register_checked_vfs(), SQLITE_OK);
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open_v2(path_.c_str(), &database, SQLITE_OPEN_READWRITE, checked_vfs), SQLITE_OK);
    char* error = nullptr;
    EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, &error), SQLITE_OK) << sql << ": " << error;
    EXPECT_EQ(sqlite3_changes(database), 1) << sql;
    sqlite3_close(database);
  }
  void clear() {
    for (const char* suffix : {"", "-wal", "-shm", "-sync"}) fs::remove(path_ + suffix);
  }

  test::TemporaryFolder folder_;
  std::string path_ = folder_ / "flight.db";
};

TEST_F(SqliteDamage, AValueThatDoesNotFitItsFieldOrItsChecksumIsDamage) {
  const Contents contents({100, 0});
  for (const std::string& change_of : std::vector<std::string>{
           "width=5", "width=x'00'", "width=4294967293", "width=2.5", "width=NULL", "time_doubt=256", "altitude=2.0",
           "altitude='x'", "altitude=NULL", "name='frame 2'", "name=name||x'00'||'y'", "name=NULL",
           "name=printf('%70d',1)", "image_bytes=99", "record_checksum=record_checksum+1", "record_checksum=NULL",
           "record_checksum=record_checksum+4294967296", "id=3"}) {
    clear();
    fill(contents);
    change("UPDATE frame SET " + change_of + " WHERE id=1");
    SqliteStore store;
    ASSERT_OK(store.open(path_.c_str()));
    const std::int64_t id = change_of == "id=3" ? 3 : 1;
    FrameRecord frame{.id = 77};
    const Status found = get(store, id, frame);
    EXPECT_STATUS(found, record_damaged) << change_of;
    EXPECT_EQ(found.a, id);
    EXPECT_EQ(found.b, static_cast<std::int64_t>(RecordType::frame));
    EXPECT_EQ(frame.id, 77) << "a damaged record was given out";
    EXPECT_STATUS(id == 3 ? last(store, frame) : next(store, 0, frame), record_damaged) << change_of;
    ASSERT_OK(next(store, 1, frame).is(StatusCode::record_damaged) ? Status{} : next(store, 1, frame));
    EXPECT_FALSE(store.damaged()) << "one record is not the database";
    std::int64_t newest = 0;
    EXPECT_OK(store.begin());
    EXPECT_OK(put(store, contents.frame(1)));
    EXPECT_OK(store.commit());
    EXPECT_OK(get(store, 1, frame)) << "a record that was put again";
    static_cast<void>(newest);
  }
}

TEST_F(SqliteDamage, ABlobThatDoesNotHaveItsChecksumsIsDamage) {
  const Contents contents({10'000, 10'000});
  for (const std::string& sql : std::vector<std::string>{
           "UPDATE frame_image SET data=CAST(x'00'||substr(data,2) AS BLOB) WHERE id=1",
           "UPDATE frame_image SET data=substr(data,1,9999) WHERE id=1",
           "UPDATE frame_image SET data=zeroblob(10000) WHERE id=1", "UPDATE frame_image SET data=NULL WHERE id=1",
           "UPDATE frame_image SET data='text' WHERE id=1", "UPDATE frame_image SET checksums=NULL WHERE id=1",
           "UPDATE frame_image SET checksums=zeroblob(12) WHERE id=1",
           "UPDATE frame_image SET checksums=zeroblob(16) WHERE id=1", "UPDATE frame_image SET id=9 WHERE id=1",
           "DELETE FROM frame_image WHERE id=1",
           "UPDATE frame_image SET data=(SELECT data FROM frame_image WHERE id=2), checksums=(SELECT checksums FROM "
           "frame_image WHERE id=2) WHERE id=1"}) {
    clear();
    fill(contents);
    change(sql);
    SqliteStore store;
    ASSERT_OK(store.open(path_.c_str()));
    Bytes image(10'000, 0xEE);
    const Status read = read_blob<FrameRecord>(store, "image", 1, 0, image);
    EXPECT_STATUS(read, record_damaged) << sql;
    EXPECT_EQ(read.a, 1);
    Bytes end(1);
    EXPECT_FALSE(read_blob<FrameRecord>(store, "image", 1, 9999, end).ok() && sql.find("9999") != std::string::npos);
    ASSERT_OK(read_blob<FrameRecord>(store, "image", 2, 0, image));
    EXPECT_TRUE(image == contents.image(2));
    // Written again, the record is valid.
    ASSERT_OK(store.begin());
    FrameRecord none = contents.frame(1);
    none.image.bytes = 0;
    ASSERT_OK(put(store, none));
    ASSERT_OK(put(store, contents.frame(1)));
    ASSERT_OK(write_blob<FrameRecord>(store, "image", 1, 0, contents.image(1)));
    ASSERT_OK(store.commit());
    EXPECT_OK(read_blob<FrameRecord>(store, "image", 1, 0, image)) << sql;
  }
}

TEST(PageChecksum, MendsAnyOneBitAndTellsWhateverElse) {
  std::mt19937 random(3);
  std::vector<std::uint8_t> bytes(page_bytes);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
  const Page page(bytes.data(), page_bytes);
  seal_page(7, page);
  const std::vector<std::uint8_t> sealed = bytes;
  EXPECT_EQ(check_page(7, page), PageState::valid);
  EXPECT_EQ(check_page(8, page), PageState::damaged) << "a page in another's place";
  const std::size_t content_bits = 8 * (page_bytes - page_checksum_bytes);
  for (std::size_t bit = 0; bit < 8 * page_bytes; bit += 1 + bit % 3) {
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    ASSERT_EQ(check_page(7, page), PageState::mended) << bit;
    ASSERT_TRUE(std::equal(bytes.begin(), bytes.end() - page_checksum_bytes, sealed.begin())) << bit;
    bytes = sealed;
  }
  for (int round = 0; round < 2000; ++round) {
    const int flips = 2 + round % 30;
    std::set<std::size_t> chosen;
    while (static_cast<int>(chosen.size()) < flips) chosen.insert(random() % content_bits);
    for (const std::size_t bit : chosen) bytes[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    ASSERT_EQ(check_page(7, page), PageState::damaged);
    bytes = sealed;
  }
}

TEST_F(SqliteDamage, OneFlippedBitOfTheFileIsMendedAndManyAreNoticed) {
  const Contents contents({10, 0, 9000, 300});
  fill(contents);
  const std::string whole = content_of(path_);
  std::mt19937 random(11);
  for (int round = 0; round < 150; ++round) {
    std::string content = whole;
    const std::size_t page = random() % (whole.size() / page_bytes);
    // One bit; a few of a page; a page of other content; a page that was never written.
    const int kind = round % 4;
    for (int i = 0; kind < 2 && i < (kind == 0 ? 1 : 7); ++i) flip(content, 8 * page * page_bytes + random() % 32768);
    if (kind == 2) content.replace(page * page_bytes, page_bytes, whole, (page + 1) % 40 * page_bytes, page_bytes);
    if (kind == 3) content.replace(page * page_bytes, page_bytes, page_bytes, '\0');
    set_content(path_, content);
    SqliteStore store;
    const Status opened = store.open(path_.c_str());
    const std::string where = "round " + std::to_string(round) + " page " + std::to_string(page + 1);
    if (opened.ok()) {
      const int noticed = contents.judge(store, where);
      if (kind == 0) {
        EXPECT_EQ(noticed, 0) << where;
        EXPECT_OK(store.check());
      }
    } else {
      EXPECT_NE(kind, 0) << where << ": one bit";
      EXPECT_TRUE(opened.is(StatusCode::store_damaged) || opened.is(StatusCode::store_schema))
          << where << ": " << status_name(opened.code);
    }
    store.close();
    for (const char* suffix : {"-wal", "-shm", "-sync"}) fs::remove(path_ + suffix);
    if (testing::Test::HasFailure()) return;
  }
}

TEST_F(SqliteDamage, AFlippedBitInTheLogIsNeverTakenForItsEnd) {
  const Contents contents({10, 0, 9000, 300, 50, 60});
  // The files as a process that died leaves them.
  std::map<std::string, std::string> dead;
  {
    SqliteStore store;
    ASSERT_OK(store.open(path_.c_str()));
    contents.fill(store);
    for (const char* suffix : {"", "-wal", "-sync"}) dead[suffix] = content_of(path_ + suffix);
  }
  const auto restore = [&] {
    clear();
    for (const auto& [suffix, content] : dead) set_content(path_ + suffix, content);
  };
  restore();
  {
    SqliteStore store;
    ASSERT_OK(store.open(path_.c_str()));
    EXPECT_EQ(contents.judge(store, "undamaged"), 0);
  }
  const std::size_t frames = (dead["-wal"].size() - log_header_bytes) / frame_bytes;
  ASSERT_GT(frames, 20U);
  std::mt19937 random(5);
  int unreadable = 0;
  int mended = 0;
  int missing = 0;
  for (int round = 0; round < 60; ++round) {
    restore();
    std::string log = dead["-wal"];
    // Headers as often as pages, the last transaction as often as the first.
    const std::size_t frame = round % 3 == 0 ? frames - 1 : random() % frames;
    const std::size_t begin = round % 10 == 9 ? 0 : log_header_bytes + frame * frame_bytes;
    const std::size_t bits = 8 * (round % 10 == 9  ? log_header_bytes
                                  : round % 2 == 0 ? frame_header_bytes
                                                   : frame_bytes);
    const std::size_t bit = 8 * begin + random() % bits;
    flip(log, bit);
    set_content(path_ + "-wal", log);
    const std::string where = "round " + std::to_string(round) + " byte " + std::to_string(bit / 8 - begin) +
                              " of frame " + std::to_string(frame);
    SqliteStore store;
    const Status opened = store.open(path_.c_str());
    EXPECT_STATUS(opened, log_damaged) << where;
    SqliteStore tool;
    EXPECT_STATUS(tool.open_read_only(path_.c_str()), log_damaged) << where;
    // Where the checksums say which bit it was, all is as it was.
    if (mend_log(path_.c_str()).ok()) {
      ++mended;
      ASSERT_OK(store.open(path_.c_str())) << where;
      EXPECT_EQ(contents.judge(store, where), 0) << where;
      store.close();
      restore();
      set_content(path_ + "-wal", log);
    }
    // Else what can be read of it is saved: all but what the bit has hit, which may be how much a page holds.
    EXPECT_OK(bridge_log(path_.c_str())) << where;
    SqliteStore salvaged;
    // A high bit of a word of the schema itself cannot be found: then nothing can be read, which is reported.
    if (!sqlite::open_damaged(salvaged.session(), path_.c_str(), 512).ok()) {
      ++unreadable;
      continue;
    }
    missing += contents.judge(salvaged, where, true);
    salvaged.close();
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_LE(unreadable, 5);
  EXPECT_LT(missing, 120) << "of 2500 answers";
  EXPECT_GT(mended, 30) << "most of the bits can be found";
}

TEST_F(SqliteDamage, ATransactionThatThePowerCutShortIsNoDamage) {
  const Contents contents({10, 0, 9000});
  SqliteStore store;
  ASSERT_OK(store.open(path_.c_str()));
  contents.fill(store);
  const std::string database = content_of(path_);
  const std::string mark = content_of(path_ + "-sync");
  const std::size_t before = content_of(path_ + "-wal").size();
  ASSERT_OK(store.begin());
  FrameRecord frame{.id = 4};
  frame.image.bytes = 20'000;
  ASSERT_OK(put(store, frame));
  ASSERT_OK(store.commit());
  const std::string log = content_of(path_ + "-wal");
  store.close();
  ASSERT_GT(log.size(), before + 3 * frame_bytes);
  // The mark of the commit before is what a disk has that was cut off within the last one; its pages came in any order.
  std::mt19937 random(2);
  for (int round = 0; round < 40; ++round) {
    clear();
    set_content(path_, database);
    set_content(path_ + "-sync", mark);
    std::string torn = log.substr(0, round % 2 == 0 ? log.size() : before + random() % (log.size() - before));
    const std::size_t hole = before + random() % (log.size() - before);
    for (std::size_t at = hole / 512 * 512; at < hole / 512 * 512 + 512 && at < torn.size(); ++at) {
      if (at >= before) torn[at] = 0;
    }
    set_content(path_ + "-wal", torn);
    SqliteStore again;
    ASSERT_OK(again.open(path_.c_str())) << round;
    if (!get(again, 4, frame).ok()) {
      EXPECT_EQ(contents.judge(again, "round " + std::to_string(round)), 0);
    }
  }
}

/// Record k has k in its time; transactions put the numbers from 1 on.
Status put_numbered(SqliteStore& store, std::int64_t number) {
  Transaction transaction(store);
  ILP_TRY(transaction.begin());
  FrameRecord frame{.id = number};
  frame.image.bytes = static_cast<std::uint32_t>(3000 + 5000 * (number % 3));
  ILP_TRY(put(store, frame));
  ILP_TRY(
      write_blob<FrameRecord>(store, "image", number, 0, Bytes(frame.image.bytes, static_cast<std::uint8_t>(number))));
  return transaction.commit();
}

/// How many of the numbered records there are; -1 if they are not the first ones, whole.
std::int64_t numbered(SqliteStore& store) {
  std::int64_t count = 0;
  FrameRecord frame;
  for (std::int64_t id = 0; next(store, id, frame).ok(); id = frame.id) {
    Bytes image(frame.image.bytes);
    if (frame.id != ++count || !read_blob<FrameRecord>(store, "image", frame.id, 0, image).ok() ||
        image != Bytes(image.size(), static_cast<std::uint8_t>(count))) {
      return -1;
    }
  }
  return count;
}

TEST_F(SqliteDamage, OfCommitsThatWereNotSynchronisedAPowerCutLeavesTheFirstOnes) {
  constexpr std::int64_t synchronised = 4, committed = 12;
  SqliteStore store, other;
  ASSERT_OK(store.open(path_.c_str()));
  ASSERT_OK(store.synchronise(Synchronise::later));
  ASSERT_OK(other.open(path_.c_str()));
  ASSERT_OK(other.synchronise(Synchronise::later));
  for (std::int64_t number = 1; number <= synchronised; ++number) {
    ASSERT_OK(put_numbered(number % 2 == 0 ? store : other, number));
  }
  // It notes the other's commits too.
  ASSERT_OK(other.flush());
  const std::size_t on_disk = content_of(path_ + "-wal").size();
  for (std::int64_t number = synchronised + 1; number <= committed; ++number) {
    ASSERT_OK(put_numbered(number % 2 == 0 ? store : other, number));
  }
  const std::string database = content_of(path_), mark = content_of(path_ + "-sync"), log = content_of(path_ + "-wal");
  store.close();
  other.close();
  ASSERT_GT(log.size(), on_disk + 8 * frame_bytes);
  std::mt19937 random(3);
  std::set<std::int64_t> left;
  for (int round = 0; round < 60; ++round) {
    clear();
    set_content(path_, database);
    set_content(path_ + "-sync", mark);
    // Sectors behind what was synchronised come in any order, and not all of them.
    std::string torn = log;
    const int holes = 1 + static_cast<int>(random() % 4);
    for (int hole = 0; hole < holes; ++hole) {
      std::size_t at = on_disk + random() % (log.size() - on_disk);
      for (at = std::max(at / 512 * 512, on_disk); at % 512 != 511 && at < torn.size(); ++at) torn[at] = 0;
    }
    set_content(path_ + "-wal", torn);
    SqliteStore again;
    ASSERT_OK(again.open(path_.c_str())) << round;
    const std::int64_t first = numbered(again);
    ASSERT_GE(first, synchronised) << "round " << round << ": what was synchronised is gone, or there are gaps";
    left.insert(first);
    // The flight goes on, and what the cut has left behind the end of the log is no damage later on either.
    ASSERT_OK(again.synchronise(round % 2 == 0 ? Synchronise::in_commit : Synchronise::behind_commit));
    ASSERT_OK(put_numbered(again, first + 1));
    EXPECT_OK(check_log(path_.c_str())) << round;
    again.close();
    ASSERT_OK(again.open(path_.c_str())) << round;
    EXPECT_EQ(numbered(again), first + 1);
  }
  EXPECT_GT(left.size(), 4U) << "the cuts should differ";
  // A flipped bit in what was synchronised is damage.
  clear();
  set_content(path_, database);
  set_content(path_ + "-sync", mark);
  std::string flipped = log;
  flip(flipped, 8 * (on_disk - 2000));
  set_content(path_ + "-wal", flipped);
  EXPECT_STATUS(store.open(path_.c_str()), log_damaged);
}

TEST_F(SqliteDamage, ADiskThatLostWhatItSaidItHadIsFoundOut) {
  const Contents contents({10, 0, 9000});
  SqliteStore store;
  ASSERT_OK(store.open(path_.c_str()));
  const std::string early = content_of(path_ + "-wal");
  contents.fill(store);
  const std::string database = content_of(path_);
  const std::string mark = content_of(path_ + "-sync");
  const std::string log = content_of(path_ + "-wal");
  store.close();
  // The end of the log, all of it, the file itself.
  for (int round = 0; round < 3; ++round) {
    clear();
    set_content(path_, database);
    set_content(path_ + "-sync", mark);
    if (round == 0) set_content(path_ + "-wal", log.substr(0, log.size() - 2 * frame_bytes));
    if (round == 1) set_content(path_ + "-wal", early.substr(0, early.size()));
    SqliteStore again;
    EXPECT_STATUS(again.open(path_.c_str()), log_damaged) << round;
  }
  // A database that was closed in order has neither.
  clear();
  {
    SqliteStore good;
    ASSERT_OK(good.open(path_.c_str()));
    contents.fill(good);
    EXPECT_TRUE(fs::exists(path_ + "-sync"));
  }
  EXPECT_FALSE(fs::exists(path_ + "-sync"));
}

TEST_F(SqliteDamage, FramesThatAreWrittenTwiceWithinATransactionAreNoDamage) {
  // Larger than the page cache, and changed again and again before the commit: SQLite then puts other pages into frames
  // of the log, and their checksums only at the end.
  SqliteStore store;
  ASSERT_OK(store.open(path_.c_str()));
  std::mt19937 random(9);
  for (int round = 0; round < 3; ++round) {
    ASSERT_OK(store.begin());
    for (std::int64_t id = 1; id <= 12; ++id) {
      FrameRecord frame{.id = id};
      frame.image.bytes = 1'000'000;
      ASSERT_OK(put(store, frame));
    }
    for (int i = 0; i < 60; ++i) {
      const auto id = static_cast<std::int64_t>(1 + random() % 12);
      ASSERT_OK(write_blob<FrameRecord>(store, "image", id, 4096 * (random() % 200),
                                        Bytes(30'000, static_cast<std::uint8_t>(i))));
      Bytes image(1'000'000);
      ASSERT_OK(read_blob<FrameRecord>(store, "image", 1 + static_cast<std::int64_t>(random() % 12), 0, image));
    }
    if (round == 1) {
      store.rollback();
    } else {
      ASSERT_OK(store.commit());
    }
  }
  EXPECT_FALSE(store.damaged());
  store.close();
  ASSERT_OK(store.open(path_.c_str()));
  EXPECT_OK(store.check());
}

TEST_F(SqliteDamage, AScrubFindsWhatNobodyReads) {
  const Contents contents({10'000, 10'000, 300});
  fill(contents);
  change("UPDATE frame SET width=5 WHERE id=2");
  change("UPDATE frame_image SET data=zeroblob(10000) WHERE id=1");
  SqliteStore store;
  ASSERT_OK(store.open(path_.c_str()));
  std::vector<std::uint8_t> scratch(8192);
  ScrubCursor cursor;
  std::vector<std::int64_t> damaged;
  for (bool complete = false; !complete;) {
    const ScrubSlice slice = scrub(store, 4000, scratch, cursor);
    ASSERT_OK(slice.fault);
    if (!slice.damage.ok()) damaged.push_back(slice.damage.a);
    complete = slice.round_complete;
  }
  EXPECT_EQ(damaged, (std::vector<std::int64_t>{1, 2}));
}

}  // namespace
}  // namespace ilp
