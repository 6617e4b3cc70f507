// What the store on a server answers to what can go wrong: refusals, other schemas, damage, strangers, full disks.
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <limits>
#include <vector>

#include "fsw/records/records.hpp"
#include "tests/distributed/postgres_backend.hpp"
#include "tests/unit/hal/small_disk.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {

using test::environment;
using test::sql;

using Bytes = std::vector<std::uint8_t>;

FrameRecord frame_of(std::int64_t id, std::uint32_t image_bytes = 0) {
  FrameRecord frame{.id = id};
  frame.image.bytes = image_bytes;
  copy_text(frame.name, "a.png");
  return frame;
}

Status put_now(Store& store, const FrameRecord& frame, std::uint8_t value = 0) {
  Transaction transaction(store);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(store, frame));
  const Bytes image(frame.image.bytes, value);
  if (!image.empty()) ILP_TRY(write_blob<FrameRecord>(store, "image", frame.id, 0, image));
  return transaction.commit();
}

class PostgresFaults : public testing::Test {
 protected:
  PostgresFaults() {
    test::empty_database();
    EXPECT_OK(open_again()) << store_->message();
  }
  Status open_again() { return store_->open(owner_.c_str(), ~RecordMask{0}); }
  Status open_as(const std::string& conninfo) {
    store_->close();
    return store_->open(conninfo.c_str(), ~RecordMask{0});
  }

  const std::string owner_ = environment("ILP_POSTGRES");
  std::unique_ptr<PostgresStore> store_ = std::make_unique<PostgresStore>();
  FrameRecord frame_;
};

TEST_F(PostgresFaults, WithoutAServerTheConnectionIsLost) {
  EXPECT_STATUS(open_as("host=127.0.0.1 port=1 user=ilp dbname=ilp"), store_lost);
  EXPECT_NE(std::string(store_->message()), "");
  EXPECT_STATUS(open_as("host=/nowhere user=ilp dbname=ilp"), store_lost);
  EXPECT_STATUS(open_as("this is no conninfo"), store_lost);
  EXPECT_STATUS(open_as(std::string(5000, 'x')), capacity_exceeded);
  EXPECT_FALSE(store_->connected());
  EXPECT_STATUS(get(*store_, 1, frame_), store_lost);
  EXPECT_STATUS(store_->begin(), store_lost);
}

TEST_F(PostgresFaults, AWrongPasswordIsRefusedAndNeverTold) {
  const std::string tcp = environment("ILP_POSTGRES_TCP");
  EXPECT_OK(open_as(tcp)) << store_->message();
  const test::TemporaryFolder folder;
  const std::string wrong = folder / "passfile";
  std::ofstream(wrong) << "*:*:*:*:secret-but-wrong\n";
  ASSERT_EQ(chmod(wrong.c_str(), 0600), 0);
  EXPECT_STATUS(open_as(tcp + " passfile=" + wrong), store_denied);
  EXPECT_EQ(std::string(store_->message()).find("secret"), std::string::npos) << store_->message();
  EXPECT_STATUS(open_as(tcp + " passfile=/nowhere"), store_denied) << "no password at all";
  EXPECT_STATUS(open_as(tcp + " dbname=nowhere"), store_denied);
}

TEST_F(PostgresFaults, ARoleMayDoWhatItIsGrantedAndTheTableIsNamed) {
  sql("DROP ROLE IF EXISTS reader; CREATE ROLE reader LOGIN; GRANT SELECT ON frame,pose,frame_image,ilp_store TO "
      "reader;"
      "GRANT UPDATE ON ilp_store TO reader; GRANT INSERT,UPDATE ON strip TO reader; GRANT SELECT ON strip TO reader");
  ASSERT_OK(put_now(*store_, frame_of(1, 10), 7));
  ASSERT_OK(open_as(owner_ + " user=reader")) << store_->message();
  EXPECT_OK(get(*store_, 1, frame_));
  KeyframeRecord keyframe;
  const Status reading = get(*store_, 1, keyframe);
  EXPECT_STATUS(reading, store_denied);
  EXPECT_EQ(reading.a, static_cast<std::int64_t>(RecordType::keyframe));
  ASSERT_OK(store_->begin());
  ASSERT_OK(put(*store_, StripRecord{.id = 1}));
  static_cast<void>(put(*store_, frame_of(2)));
  const Status writing = store_->commit();
  EXPECT_STATUS(writing, store_denied);
  EXPECT_EQ(writing.a, static_cast<std::int64_t>(RecordType::frame));
  StripRecord strip;
  EXPECT_STATUS(get(*store_, 1, strip), not_found) << "a part of the transaction was committed";
  ASSERT_OK(store_->begin());
  ASSERT_OK(put(*store_, StripRecord{.id = 1}));
  EXPECT_OK(store_->commit()) << "the role goes on with what it may do";
  store_->close();
  sql("DROP OWNED BY reader; DROP ROLE reader");
}

TEST_F(PostgresFaults, AnEmptyDatabaseIsNotMadeByARoleThatMayNot) {
  test::empty_database();
  sql("DROP ROLE IF EXISTS reader; CREATE ROLE reader LOGIN");
  EXPECT_STATUS(open_as(owner_ + " user=reader"), store_denied);
  sql("DROP ROLE reader");
  EXPECT_OK(open_again());
}

TEST_F(PostgresFaults, TablesOfAnotherVersionAreRefusedAndLeftUntouched) {
  ASSERT_OK(put_now(*store_, frame_of(1)));
  sql("UPDATE ilp_store SET fingerprint=1");
  const Status refused = open_again();
  EXPECT_STATUS(refused, store_schema);
  EXPECT_EQ(refused.a, 1);
  EXPECT_EQ(sql("SELECT count(*) FROM frame"), "1");
}

TEST_F(PostgresFaults, ADatabaseThatDoesNotTakeEveryByteIsRefused) {
  sql("CREATE DATABASE wide ENCODING 'UTF8' TEMPLATE template0 OWNER ilp");
  EXPECT_STATUS(open_as(owner_ + " dbname=wide"), store_schema);
  store_->close();
  sql("DROP DATABASE wide");
}

TEST_F(PostgresFaults, ATableThatIsGoneIsDamageAndTheOthersGoOn) {
  ASSERT_OK(put_now(*store_, frame_of(1)));
  PoseRecord pose;
  EXPECT_STATUS(get(*store_, 1, pose), not_found);
  sql("DROP TABLE pose");
  EXPECT_STATUS(get(*store_, 2, pose), store_damaged);
  EXPECT_OK(get(*store_, 1, frame_));
  ASSERT_OK(store_->begin());
  static_cast<void>(put(*store_, pose));
  EXPECT_STATUS(store_->commit(), store_damaged);
  EXPECT_OK(put_now(*store_, frame_of(2)));
  sql("DELETE FROM ilp_store");
  EXPECT_STATUS(get(*store_, 5, frame_), store_damaged);
  EXPECT_STATUS(put_now(*store_, frame_of(3)), store_damaged);
}

TEST_F(PostgresFaults, CountersThatAStrangerHasChangedLeadToNothingWorseThanReadingAgain) {
  ASSERT_OK(put_now(*store_, frame_of(1)));
  EXPECT_OK(get(*store_, 1, frame_));
  sql("UPDATE ilp_store SET commits=-5, frame=9223372036854775807");
  EXPECT_OK(get(*store_, 1, frame_));
  EXPECT_STATUS(get(*store_, 2, frame_), not_found);
  EXPECT_OK(put_now(*store_, frame_of(2)));
  EXPECT_OK(get(*store_, 2, frame_));
  sql("UPDATE ilp_store SET pose=NULL");
  EXPECT_STATUS(get(*store_, 3, frame_), store_damaged);
  sql("UPDATE ilp_store SET pose=0");
  EXPECT_STATUS(get(*store_, 3, frame_), not_found);
}

// A stranger writes into every column in turn what its field cannot be.
TEST_F(PostgresFaults, AValueThatDoesNotFitItsFieldOrItsChecksumIsDamage) {
  const RecordInfo& info = record_info<FrameRecord>();
  ASSERT_OK(put_now(*store_, frame_of(1)));
  ASSERT_OK(put_now(*store_, frame_of(3)));
  std::size_t tried = 0;
  const auto expect_damage = [&](const std::string& change) {
    ASSERT_OK(put_now(*store_, frame_of(2, 10), 5));
    sql("UPDATE frame SET " + change + " WHERE id=2");
    ASSERT_OK(open_again());
    const Status read = get(*store_, 2, frame_);
    EXPECT_STATUS(read, record_damaged) << change;
    EXPECT_EQ(read.a, 2);
    EXPECT_STATUS(next(*store_, 1, frame_), record_damaged) << change;
    ASSERT_OK(next(*store_, 2, frame_));
    EXPECT_EQ(frame_.id, 3);
    ++tried;
  };
  for (std::size_t f = 1; f < info.field_count; ++f) {
    const FieldInfo& field = info.fields[f];
    const std::string column = std::string("\"") + field.name + (field.type == FieldType::blob ? "_bytes\"" : "\"");
    expect_damage(column + "=NULL");
    if (field.type == FieldType::text) {
      expect_damage(column + "=repeat('x',64)");
    } else if (field.type == FieldType::f64 || field.type == FieldType::i64) {
      expect_damage(column + "=12345");
    } else {
      expect_damage(column + "=1099511627776");
      expect_damage(column + "=-1099511627776");
    }
  }
  expect_damage("record_checksum=record_checksum+4294967296");
  expect_damage("record_checksum=NULL");
  EXPECT_GT(tried, 15U);
  EXPECT_OK(put_now(*store_, frame_of(2))) << "a put mends it";
  EXPECT_OK(get(*store_, 2, frame_));
}

TEST_F(PostgresFaults, ABlobThatDoesNotHaveItsChecksumsIsDamage) {
  const auto refill = [&] {
    ASSERT_OK(put_now(*store_, frame_of(1)));
    ASSERT_OK(put_now(*store_, frame_of(1, 10'000), 9));
  };
  Bytes image(10'000);
  Bytes chunk(blob_chunk_bytes);
  for (const char* change :
       {"data=data||'x'", "data=substring(data FROM 2)", "data=NULL", "data=''", "bytes=9999", "bytes=NULL", "bytes=-1",
        "bytes=9223372036854775807", "checksums=''", "checksums=NULL", "checksums=checksums||'x'",
        "checksums=substring(checksums FROM 5)||substring(checksums FOR 4)", "data=set_byte(data,5000,1)"}) {
    refill();
    ASSERT_OK(read_blob<FrameRecord>(*store_, "image", 1, 0, image));
    EXPECT_EQ(image, Bytes(10'000, 9));
    std::fill(image.begin(), image.end(), std::uint8_t{0});
    sql(std::string("UPDATE frame_image SET ") + change + " WHERE id=1");
    ASSERT_OK(open_again());
    EXPECT_STATUS(read_blob<FrameRecord>(*store_, "image", 1, 0, image), record_damaged) << change;
    EXPECT_EQ(image, Bytes(10'000, 0)) << change << ": bytes of a damaged blob were given out";
  }
  // The latest change leaves the other chunks sound; a part of the damaged one cannot be written, the whole one can.
  EXPECT_OK(read_blob<FrameRecord>(*store_, "image", 1, 0, chunk));
  ASSERT_OK(store_->begin());
  EXPECT_STATUS(write_blob<FrameRecord>(*store_, "image", 1, 5000, Bytes(3, 1)), record_damaged);
  store_->rollback();
  ASSERT_OK(store_->begin());
  ASSERT_OK(write_blob<FrameRecord>(*store_, "image", 1, blob_chunk_bytes, Bytes(blob_chunk_bytes, 4)));
  ASSERT_OK(store_->commit());
  ASSERT_OK(read_blob<FrameRecord>(*store_, "image", 1, 0, image));
  EXPECT_EQ(image[5000], 4);
  sql("DELETE FROM frame_image");
  ASSERT_OK(open_again());
  EXPECT_STATUS(read_blob<FrameRecord>(*store_, "image", 1, 0, image), record_damaged)
      << "missing, and not `not_found`";
}

TEST_F(PostgresFaults, ColumnsOfAnotherTypeAreAStatus) {
  ASSERT_OK(put_now(*store_, frame_of(1, 10), 5));
  for (const char* change :
       {"ALTER TABLE frame ALTER width TYPE text", "ALTER TABLE frame ALTER width TYPE boolean USING true",
        "ALTER TABLE frame DROP COLUMN width", "ALTER TABLE frame DROP COLUMN id CASCADE"}) {
    sql(change);
    ASSERT_OK(open_again());
    EXPECT_FALSE(get(*store_, 1, frame_).ok()) << change;
    EXPECT_FALSE(next(*store_, 0, frame_).ok()) << change;
    EXPECT_FALSE(put_now(*store_, frame_of(2)).ok()) << change;
  }
}

TEST_F(PostgresFaults, ALimitedStoreIsFullButErasesAndTakesAgain) {
  store_->limit(store_->usage().bytes + 250'000);
  ASSERT_OK(put_now(*store_, frame_of(1, 100'000), 1));
  ASSERT_OK(put_now(*store_, frame_of(2, 100'000), 1));
  ASSERT_OK(put_now(*store_, frame_of(2, 100'000), 2)) << "the same size again";
  EXPECT_STATUS(put_now(*store_, frame_of(3, 100'000), 1), store_full);
  const StoreUsage usage = store_->usage();
  EXPECT_LE(usage.bytes, usage.limit_bytes);
  ASSERT_OK(store_->begin());
  ASSERT_OK(store_->erase(record_info<FrameRecord>(), 1));
  ASSERT_OK(store_->commit());
  EXPECT_OK(put_now(*store_, frame_of(3, 100'000), 1));
  EXPECT_STATUS(get(*store_, 1, frame_), not_found);
}

TEST_F(PostgresFaults, WhatOthersHavePutCountsForTheLimit) {
  ASSERT_OK(put_now(*store_, frame_of(1, 100'000), 1));
  const auto other = std::make_unique<PostgresStore>();
  ASSERT_OK(other->open(owner_.c_str(), 0));
  const std::int64_t limit = store_->usage().bytes + 250'000;
  for (PostgresStore* store : {store_.get(), other.get()}) store->limit(limit);
  ASSERT_OK(put_now(*other, frame_of(2, 100'000), 1));
  ASSERT_OK(put_now(*store_, frame_of(3, 100'000), 1));
  EXPECT_STATUS(put_now(*other, frame_of(4, 100'000), 1), store_full);
  EXPECT_STATUS(put_now(*store_, frame_of(5, 100'000), 1), store_full);
  EXPECT_LE(store_->usage().bytes, limit);
}

TEST_F(PostgresFaults, ABlobBeyondTheCapacityIsRefused) {
  ASSERT_OK(put_now(*store_, frame_of(1, max_postgres_blob_bytes), 3));
  Bytes image(max_postgres_blob_bytes);
  ASSERT_OK(read_blob<FrameRecord>(*store_, "image", 1, 0, image));
  EXPECT_EQ(image, Bytes(max_postgres_blob_bytes, 3));
  EXPECT_STATUS(put_now(*store_, frame_of(2, max_postgres_blob_bytes + 1)), capacity_exceeded);
  EXPECT_STATUS(get(*store_, 2, frame_), not_found);
}

TEST_F(PostgresFaults, AServerWithoutRoomForAnImageSaysSoAndTakesItWhenThereIsRoom) {
  const test::TemporaryFolder folder;
  const test::SmallDisk disk(folder / "disk", 4);
  if (!disk.mounted()) GTEST_SKIP() << "no right to mount a small disk";
  ASSERT_EQ(system(("chmod 755 " + folder.path().string() + "; chown postgres " + disk.path()).c_str()), 0);
  sql("CREATE TABLESPACE small LOCATION '" + disk.path() + "'");
  sql("ALTER TABLE frame_image SET TABLESPACE small");
  ASSERT_OK(open_again());
  std::int64_t id = 0;
  Status status;
  while (status.ok() && id < 20) status = put_now(*store_, frame_of(++id, 1'000'000), 1);
  EXPECT_STATUS(status, store_full);
  EXPECT_STATUS(get(*store_, id, frame_), not_found) << "a part of the transaction was committed";
  EXPECT_OK(get(*store_, id - 1, frame_));
  ASSERT_OK(store_->begin());
  for (std::int64_t old = 1; old < id; ++old) ASSERT_OK(store_->erase(record_info<FrameRecord>(), old));
  ASSERT_OK(store_->commit());
  EXPECT_STATUS(get(*store_, id - 1, frame_), not_found) << "erasing goes on";
  ASSERT_TRUE(disk.resize(12));
  EXPECT_OK(put_now(*store_, frame_of(id, 1'000'000), 1));
  store_->close();
  test::empty_database();
  sql("DROP TABLESPACE small");
}

}  // namespace
}  // namespace ilp
