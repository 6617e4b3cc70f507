// What every backend of the store promises (hal/store/store.hpp), one suite for all of them.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <random>
#include <vector>

#include "fsw/records/serial.hpp"
#ifdef ILP_CONTRACT_OF_POSTGRES
#include "tests/distributed/postgres_backend.hpp"
#else
#include "hal/store/ram/ram_store.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"
#endif
#include "tests/unit/hal/expect_status.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {

using Bytes = std::vector<std::uint8_t>;

#ifdef ILP_CONTRACT_OF_POSTGRES
// It needs a server, so it is a program of its own (tests/distributed).
using Backends = testing::Types<test::PostgresBackend>;
#else
struct RamBackend {
  std::vector<std::byte> region = std::vector<std::byte>(std::size_t{16} << 20U);
  RamStore store{region};
};

struct SqliteBackend {
  test::TemporaryFolder folder;
  SqliteStore store;
  SqliteBackend() { EXPECT_OK(store.open((folder / "flight.db").c_str())); }
};

using Backends = testing::Types<RamBackend, SqliteBackend>;
#endif

template <typename Backend>
class StoreContract : public testing::Test {
 protected:
  Backend backend_;
  Store& store_ = backend_.store;

  template <typename Record>
  void put_now(const Record& record) {
    ASSERT_OK(store_.begin());
    ASSERT_OK(put(store_, record));
    ASSERT_OK(store_.commit());
  }
  void write_now(const char* field, std::int64_t id, std::size_t offset, const Bytes& bytes) {
    ASSERT_OK(store_.begin());
    ASSERT_OK(write_blob<FrameRecord>(store_, field, id, offset, bytes));
    ASSERT_OK(store_.commit());
  }
  Bytes image_of(std::int64_t id, std::size_t bytes) {
    Bytes image(bytes, 0xEE);
    EXPECT_OK(read_blob<FrameRecord>(store_, "image", id, 0, image));
    return image;
  }
};

FrameRecord frame_of(std::int64_t id, std::uint32_t image_bytes = 0) {
  FrameRecord frame{.id = id};
  frame.image.bytes = image_bytes;
  return frame;
}

TYPED_TEST_SUITE(StoreContract, Backends);

TYPED_TEST(StoreContract, GivesBackEveryFieldOfARecord) {
  PoseRecord pose;
  pose.id = 7;
  pose.strip_id = -3;
  pose.state = PoseState::final;
  pose.verdict = static_cast<PoseVerdict>(255);
  pose.scale_source = ScaleSource::altimeter;
  for (int i = 0; i < 4; ++i) pose.q_cam_from_world[i] = 0.1 * i - 0.05;
  for (int i = 0; i < 3; ++i) pose.centre[i] = 1e300 / (i + 1);
  for (int i = 0; i < 3; ++i) pose.sigma[i] = 5e-324 * (i + 1);
  pose.matches = std::numeric_limits<std::uint32_t>::max();
  pose.inliers = 1;
  pose.points = 2;
  pose.rms_px = 1.0 / 3;
  pose.gric_e = -std::numeric_limits<double>::infinity();
  pose.gric_h = 3;
  pose.parallax_px = 0.1;
  pose.scale_step = 1 + 1e-15;
  pose.two_view_verdict = TwoViewVerdict::ill_conditioned;
  pose.min_depth = 12.5;
  pose.max_depth = 1e10;
  this->put_now(pose);
  PoseRecord read;
  ASSERT_OK(get(this->store_, 7, read));
  EXPECT_EQ(read.id, 7);
  EXPECT_EQ(read.strip_id, -3);
  EXPECT_EQ(read.state, PoseState::final);
  EXPECT_EQ(static_cast<int>(read.verdict), 255);
  EXPECT_EQ(read.scale_source, ScaleSource::altimeter);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(read.q_cam_from_world[i], 0.1 * i - 0.05);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(read.centre[i], 1e300 / (i + 1));
  for (int i = 0; i < 3; ++i) EXPECT_EQ(read.sigma[i], 5e-324 * (i + 1));
  EXPECT_EQ(read.matches, 4294967295U);
  EXPECT_EQ(read.inliers, 1U);
  EXPECT_EQ(read.points, 2U);
  EXPECT_EQ(read.rms_px, 1.0 / 3);
  EXPECT_EQ(read.gric_e, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(read.gric_h, 3);
  EXPECT_EQ(read.parallax_px, 0.1);
  EXPECT_EQ(read.scale_step, 1 + 1e-15);
  EXPECT_EQ(read.two_view_verdict, TwoViewVerdict::ill_conditioned);
  EXPECT_EQ(read.min_depth, 12.5);
  EXPECT_EQ(read.max_depth, 1e10);
}

TYPED_TEST(StoreContract, EveryRecordTypeCanBeStored) {
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    const RecordInfo& info = record_info(static_cast<RecordType>(t));
    alignas(8) std::uint8_t written[limits::max_record_bytes] = {};
    alignas(8) std::uint8_t read[limits::max_record_bytes] = {};
    // Bytes below 128 are numbers and characters alike, and no blob gets large.
    Bytes serial(serial_bytes(info));
    for (std::size_t i = 0; i < serial.size(); ++i) serial[i] = static_cast<std::uint8_t>(1 + (i * 7 + t) % 100);
    ASSERT_OK(deserialize(info, serial, written));
    for (std::size_t f = 0; f < info.field_count; ++f) {
      if (info.fields[f].type == FieldType::blob) std::memset(written + info.fields[f].offset, 0, sizeof(Blob));
    }
    ASSERT_OK(serialize(info, written, serial));
    std::int64_t id = 0;
    std::memcpy(&id, written, sizeof(id));
    ASSERT_OK(this->store_.begin());
    ASSERT_OK(this->store_.put(info, written));
    ASSERT_OK(this->store_.commit());
    ASSERT_OK(this->store_.get(info, id, read)) << info.name;
    Bytes again(serial.size());
    ASSERT_OK(serialize(info, read, again));
    EXPECT_EQ(again, serial) << info.name;
  }
}

TYPED_TEST(StoreContract, NotANumberStaysNotANumber) {
  FrameRecord frame = frame_of(1);
  frame.altitude = std::numeric_limits<double>::quiet_NaN();
  this->put_now(frame);
  frame.altitude = 0;
  ASSERT_OK(get(this->store_, 1, frame));
  EXPECT_TRUE(std::isnan(frame.altitude));
}

TYPED_TEST(StoreContract, TextEndsAtItsTerminatorAndIsAlwaysTerminated) {
  FrameRecord frame = frame_of(1);
  std::memset(frame.name, 'x', sizeof(frame.name));
  this->put_now(frame);
  FrameRecord read;
  ASSERT_OK(get(this->store_, 1, read));
  EXPECT_EQ(std::string(read.name, sizeof(read.name)), std::string(63, 'x') + '\0');

  std::memcpy(frame.name, "a\0b'\";--", 9);
  this->put_now(frame);
  ASSERT_OK(get(this->store_, 1, read));
  EXPECT_EQ(std::string(read.name, sizeof(read.name)), "a" + std::string(63, '\0'));

  std::memset(frame.name, 0, sizeof(frame.name));
  std::memcpy(frame.name, "b'\";-- \xFF\x80", 9);
  this->put_now(frame);
  ASSERT_OK(get(this->store_, 1, read));
  EXPECT_STREQ(read.name, "b'\";-- \xFF\x80");
}

TYPED_TEST(StoreContract, WalksInTheOrderOfIdsNegativeAndLargeOnesToo) {
  constexpr std::int64_t smallest = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t largest = std::numeric_limits<std::int64_t>::max();
  const std::vector<std::int64_t> ids = {5, largest, -1, 0, smallest, 4000000000, -4000000000};
  for (const std::int64_t id : ids) this->put_now(frame_of(id));
  std::vector<std::int64_t> sorted = ids;
  std::sort(sorted.begin(), sorted.end());

  std::vector<std::int64_t> seen = {smallest};
  FrameRecord frame;
  ASSERT_OK(get(this->store_, smallest, frame));
  while (next(this->store_, seen.back(), frame).ok()) seen.push_back(frame.id);
  EXPECT_EQ(seen, sorted);
  EXPECT_STATUS(next(this->store_, largest, frame), not_found);
  ASSERT_OK(next(this->store_, 6, frame));
  EXPECT_EQ(frame.id, 4000000000);
  ASSERT_OK(last(this->store_, frame));
  EXPECT_EQ(frame.id, largest);
  std::int64_t records = 0;
  ASSERT_OK(this->store_.count(record_info<FrameRecord>(), records));
  EXPECT_EQ(records, 7);
}

TYPED_TEST(StoreContract, WhatIsNotThereIsNotFound) {
  FrameRecord frame = frame_of(42);
  EXPECT_STATUS(get(this->store_, 1, frame), not_found);
  EXPECT_STATUS(next(this->store_, 0, frame), not_found);
  EXPECT_STATUS(last(this->store_, frame), not_found);
  EXPECT_EQ(frame.id, 42) << "a record that was not found must not be written to";
  std::int64_t records = -1;
  ASSERT_OK(this->store_.count(record_info<FrameRecord>(), records));
  EXPECT_EQ(records, 0);
  Bytes byte(1);
  EXPECT_STATUS(read_blob<FrameRecord>(this->store_, "image", 1, 0, byte), not_found);
  ASSERT_OK(this->store_.begin());
  EXPECT_STATUS(this->store_.erase(record_info<FrameRecord>(), 1), not_found);
  EXPECT_STATUS(write_blob<FrameRecord>(this->store_, "image", 1, 0, byte), not_found);
  ASSERT_OK(this->store_.commit()) << "an answer of `not_found` is no fault";
}

TYPED_TEST(StoreContract, EraseTakesTheRecordAndItsBlobs) {
  this->put_now(frame_of(1, 10));
  this->put_now(frame_of(2, 10));
  this->write_now("image", 1, 0, Bytes(10, 9));
  this->write_now("image", 2, 0, Bytes(10, 8));
  ASSERT_OK(this->store_.begin());
  ASSERT_OK(this->store_.erase(record_info<FrameRecord>(), 1));
  ASSERT_OK(this->store_.commit());
  FrameRecord frame;
  EXPECT_STATUS(get(this->store_, 1, frame), not_found);
  Bytes bytes(10);
  EXPECT_STATUS(read_blob<FrameRecord>(this->store_, "image", 1, 0, bytes), not_found);
  EXPECT_EQ(this->image_of(2, 10), Bytes(10, 8));
  this->put_now(frame_of(1, 10));
  EXPECT_EQ(this->image_of(1, 10), Bytes(10, 0)) << "bytes of an erased record came back";
}

TYPED_TEST(StoreContract, BlobsAreWrittenAndReadInPieces) {
  this->put_now(frame_of(1, 100000));
  EXPECT_EQ(this->image_of(1, 100000), Bytes(100000, 0)) << "a new blob is zero";
  Bytes expected(100000, 0);
  for (std::size_t offset : {0U, 1U, 4000U, 50001U, 99993U}) {
    Bytes chunk(7);
    for (std::size_t i = 0; i < chunk.size(); ++i) chunk[i] = static_cast<std::uint8_t>(offset + i + 1);
    std::copy(chunk.begin(), chunk.end(), expected.begin() + static_cast<std::ptrdiff_t>(offset));
    this->write_now("image", 1, offset, chunk);
  }
  EXPECT_EQ(this->image_of(1, 100000), expected);
  Bytes middle(5000);
  ASSERT_OK(read_blob<FrameRecord>(this->store_, "image", 1, 47000, middle));
  EXPECT_EQ(middle, Bytes(expected.begin() + 47000, expected.begin() + 52000));
  EXPECT_OK(read_blob<FrameRecord>(this->store_, "image", 1, 100000, {}));
}

TYPED_TEST(StoreContract, BlobAccessOutsideIsRefused) {
  this->put_now(frame_of(1, 10));
  this->put_now(frame_of(2, 0));
  Bytes bytes(11);
  constexpr std::size_t huge = std::numeric_limits<std::size_t>::max();
  EXPECT_STATUS(read_blob<FrameRecord>(this->store_, "image", 1, 0, bytes), invalid_argument);
  EXPECT_STATUS(read_blob<FrameRecord>(this->store_, "image", 1, huge - 5, bytes), invalid_argument);
  EXPECT_STATUS(read_blob<FrameRecord>(this->store_, "name", 1, 0, bytes), invalid_argument);
  EXPECT_STATUS(read_blob<FrameRecord>(this->store_, "", 1, 0, bytes), invalid_argument);
  EXPECT_STATUS(read_blob<FrameRecord>(this->store_, nullptr, 1, 0, bytes), invalid_argument);
  EXPECT_STATUS(read_blob<FrameRecord>(this->store_, "image", 2, 0, bytes), not_found) << "size 0 is no blob";
  ASSERT_OK(this->store_.begin());
  EXPECT_STATUS(write_blob<FrameRecord>(this->store_, "image", 1, 4, Bytes(7)), invalid_argument);
  EXPECT_STATUS(write_blob<FrameRecord>(this->store_, "image", 1, huge, Bytes(7)), invalid_argument);
  EXPECT_STATUS(write_blob<FrameRecord>(this->store_, "pixels", 1, 0, Bytes(7)), invalid_argument);
  ASSERT_OK(this->store_.commit()) << "a refused argument is no fault";
  EXPECT_EQ(this->image_of(1, 10), Bytes(10, 0));
}

TYPED_TEST(StoreContract, BlobKeepsItsBytesWhileItsSizeStays) {
  this->put_now(frame_of(1, 10));
  this->write_now("image", 1, 0, Bytes(10, 7));
  FrameRecord frame = frame_of(1, 10);
  frame.width = 5;
  this->put_now(frame);
  EXPECT_EQ(this->image_of(1, 10), Bytes(10, 7));
  for (const std::uint32_t bytes : {11U, 10U}) {
    this->put_now(frame_of(1, bytes));
    EXPECT_EQ(this->image_of(1, bytes), Bytes(bytes, 0));
  }
  this->put_now(frame_of(1, 0));
  Bytes bytes(1);
  EXPECT_STATUS(read_blob<FrameRecord>(this->store_, "image", 1, 0, bytes), not_found);
}

TYPED_TEST(StoreContract, BlobsOfARecordAreApart) {
  DepthRecord depth{.id = 1};
  depth.values.bytes = 4;
  depth.sigma.bytes = 4;
  depth.cells.bytes = 4;
  this->put_now(depth);
  ASSERT_OK(this->store_.begin());
  ASSERT_OK(write_blob<DepthRecord>(this->store_, "values", 1, 0, Bytes(4, 1)));
  ASSERT_OK(write_blob<DepthRecord>(this->store_, "sigma", 1, 0, Bytes(4, 2)));
  ASSERT_OK(write_blob<DepthRecord>(this->store_, "cells", 1, 0, Bytes(4, 3)));
  ASSERT_OK(this->store_.commit());
  depth.sigma.bytes = 0;
  this->put_now(depth);
  Bytes bytes(4);
  ASSERT_OK(read_blob<DepthRecord>(this->store_, "values", 1, 0, bytes));
  EXPECT_EQ(bytes, Bytes(4, 1));
  ASSERT_OK(read_blob<DepthRecord>(this->store_, "cells", 1, 0, bytes));
  EXPECT_EQ(bytes, Bytes(4, 3));
  EXPECT_STATUS(read_blob<DepthRecord>(this->store_, "sigma", 1, 0, bytes), not_found);
}

TYPED_TEST(StoreContract, WritesOutsideATransactionAreRefused) {
  this->put_now(frame_of(1, 4));
  EXPECT_STATUS(put(this->store_, frame_of(2)), invalid_argument);
  EXPECT_STATUS(this->store_.erase(record_info<FrameRecord>(), 1), invalid_argument);
  EXPECT_STATUS(write_blob<FrameRecord>(this->store_, "image", 1, 0, Bytes(4, 1)), invalid_argument);
  EXPECT_STATUS(this->store_.commit(), invalid_argument);
  this->store_.rollback();
  ASSERT_OK(this->store_.begin());
  EXPECT_STATUS(this->store_.begin(), invalid_argument) << "transactions do not nest";
  ASSERT_OK(this->store_.commit());
  FrameRecord frame;
  EXPECT_STATUS(get(this->store_, 2, frame), not_found);
  EXPECT_EQ(this->image_of(1, 4), Bytes(4, 0));
}

TYPED_TEST(StoreContract, TransactionRollsBackOnEveryWayOutButCommit) {
  {
    Transaction transaction(this->store_);
    ASSERT_OK(transaction.begin());
    ASSERT_OK(put(this->store_, frame_of(1)));
    FrameRecord frame;
    EXPECT_OK(get(this->store_, 1, frame)) << "a transaction sees its own writes";
  }
  FrameRecord frame;
  EXPECT_STATUS(get(this->store_, 1, frame), not_found);
  {
    Transaction transaction(this->store_);
    ASSERT_OK(transaction.begin());
    ASSERT_OK(put(this->store_, frame_of(1)));
    ASSERT_OK(transaction.commit());
  }
  EXPECT_OK(get(this->store_, 1, frame));
}

TYPED_TEST(StoreContract, AFaultDoomsItsTransaction) {
  this->put_now(frame_of(1, 10));
  ASSERT_OK(this->store_.begin());
  ASSERT_OK(put(this->store_, frame_of(2)));
  const Status fault = put(this->store_, frame_of(3, 0xFFFFFFFF));
  ASSERT_FALSE(fault.ok()) << "a blob larger than any store";
  EXPECT_EQ(put(this->store_, frame_of(4)).code, fault.code);
  EXPECT_EQ(this->store_.commit().code, fault.code);
  std::int64_t records = 0;
  ASSERT_OK(this->store_.count(record_info<FrameRecord>(), records));
  EXPECT_EQ(records, 1) << "part of a transaction was committed";
  this->put_now(frame_of(5));
}

TYPED_TEST(StoreContract, PollTellsWhatHasChangedOnceAndOnlyWhenCommitted) {
  RecordMask changed = 1;
  ASSERT_OK(this->store_.poll(changed));
  EXPECT_EQ(changed, 0U);

  ASSERT_OK(this->store_.begin());
  ASSERT_OK(put(this->store_, frame_of(1, 4)));
  ASSERT_OK(put(this->store_, StripRecord{.id = 1}));
  ASSERT_OK(this->store_.poll(changed));
  EXPECT_EQ(changed, 0U) << "before the commit";
  ASSERT_OK(this->store_.commit());
  ASSERT_OK(this->store_.poll(changed));
  EXPECT_EQ(changed, mask_of(RecordType::frame, RecordType::strip));
  ASSERT_OK(this->store_.poll(changed));
  EXPECT_EQ(changed, 0U) << "the second time";

  this->put_now(StripRecord{.id = 2});
  this->put_now(frame_of(3));
  ASSERT_OK(this->store_.poll(changed));
  EXPECT_EQ(changed, mask_of(RecordType::frame, RecordType::strip)) << "two commits between two polls";

  ASSERT_OK(this->store_.begin());
  ASSERT_OK(put(this->store_, frame_of(2)));
  this->store_.rollback();
  ASSERT_OK(this->store_.poll(changed));
  EXPECT_EQ(changed, 0U) << "after a rollback";

  this->write_now("image", 1, 0, Bytes(4, 1));
  ASSERT_OK(this->store_.poll(changed));
  EXPECT_EQ(changed, mask_of(RecordType::frame)) << "a blob alone";

  ASSERT_OK(this->store_.begin());
  ASSERT_OK(this->store_.erase(record_info<StripRecord>(), 1));
  EXPECT_STATUS(this->store_.erase(record_info<FrameRecord>(), 9), not_found);
  ASSERT_OK(this->store_.commit());
  ASSERT_OK(this->store_.poll(changed));
  EXPECT_EQ(changed, mask_of(RecordType::strip)) << "an erased record, and one that was not there";
}

TYPED_TEST(StoreContract, UsageGrowsAndSpaceIsUsedAgain) {
  const auto used = [&] { return this->store_.usage().bytes - this->store_.usage().free_bytes; };
  const std::int64_t before = used();
  for (int round = 0; round < 5; ++round) {
    for (std::int64_t id = 1; id <= 10; ++id) this->put_now(frame_of(id, 100000));
    EXPECT_GE(used(), before + 1000000);
    EXPECT_LE(this->store_.usage().bytes, std::int64_t{18} << 20U);
    for (std::int64_t id = 1; id <= 10; ++id) {
      ASSERT_OK(this->store_.begin());
      ASSERT_OK(this->store_.erase(record_info<FrameRecord>(), id));
      ASSERT_OK(this->store_.commit());
    }
    EXPECT_LE(used(), before + 100000);
  }
}

// A store as one would write it down in two lines, to compare with.
struct Model {
  struct Row {
    Bytes fields;
    Bytes blobs[3];
    bool operator==(const Row&) const = default;
  };
  std::map<std::int64_t, Row> rows;
};

Model::Row row_of(const DepthRecord& record) {
  Model::Row row;
  row.fields.resize(serial_bytes(record_info<DepthRecord>()));
  EXPECT_OK(serialize(record_info<DepthRecord>(), &record, row.fields));
  return row;
}

std::map<std::int64_t, Model::Row> contents(Store& store) {
  std::map<std::int64_t, Model::Row> rows;
  DepthRecord record;
  for (std::int64_t after = std::numeric_limits<std::int64_t>::min(); next(store, after, record).ok();) {
    after = record.id;
    Model::Row row = row_of(record);
    const std::uint32_t sizes[3] = {record.values.bytes, record.sigma.bytes, record.cells.bytes};
    const char* const names[3] = {"values", "sigma", "cells"};
    for (int b = 0; b < 3; ++b) {
      row.blobs[b].resize(sizes[b]);
      if (sizes[b] == 0) continue;
      EXPECT_OK(read_blob<DepthRecord>(store, names[b], record.id, 0, row.blobs[b]));
    }
    rows[record.id] = row;
  }
  return rows;
}

TYPED_TEST(StoreContract, AnySequenceOfWritesEndsAsInAPlainMap) {
  std::mt19937 random(20050905);
  const auto below = [&](unsigned bound) { return static_cast<unsigned>(random() % bound); };
  const std::uint32_t sizes[] = {0, 0, 10, 10, 10, 5000, 9000};
  const char* const names[3] = {"values", "sigma", "cells"};
  Model committed;
  for (int transaction = 0; transaction < 150; ++transaction) {
    Model model = committed;
    ASSERT_OK(this->store_.begin());
    const unsigned writes = below(12);
    for (unsigned w = 0; w < writes; ++w) {
      const std::int64_t id = static_cast<std::int64_t>(below(6)) - 2;
      switch (below(4)) {
        case 0:
        case 1: {
          DepthRecord record;
          record.id = id;
          record.valid = static_cast<std::uint32_t>(random());
          record.offset = static_cast<double>(random()) / 7;
          Blob* const blobs[3] = {&record.values, &record.sigma, &record.cells};
          for (Blob* blob : blobs) blob->bytes = sizes[below(7)];
          ASSERT_OK(put(this->store_, record));
          Model::Row row = row_of(record);
          for (int b = 0; b < 3; ++b) {
            const Bytes& before = model.rows[id].blobs[b];
            row.blobs[b] = before.size() == blobs[b]->bytes ? before : Bytes(blobs[b]->bytes, 0);
          }
          model.rows[id] = row;
          break;
        }
        case 2: {
          const bool there = model.rows.erase(id) != 0;
          EXPECT_EQ(this->store_.erase(record_info<DepthRecord>(), id).ok(), there);
          break;
        }
        default: {
          const unsigned b = below(3);
          const auto row = model.rows.find(id);
          if (row == model.rows.end() || row->second.blobs[b].empty()) break;
          Bytes& blob = row->second.blobs[b];
          const std::size_t offset = below(static_cast<unsigned>(blob.size()));
          const Bytes chunk(1 + below(static_cast<unsigned>(blob.size() - offset)),
                            static_cast<std::uint8_t>(random()));
          ASSERT_OK(write_blob<DepthRecord>(this->store_, names[b], id, offset, chunk));
          std::copy(chunk.begin(), chunk.end(), blob.begin() + static_cast<std::ptrdiff_t>(offset));
        }
      }
    }
    if (below(3) == 0) {
      this->store_.rollback();
    } else {
      if (below(4) == 0) {
        ASSERT_EQ(contents(this->store_), model.rows) << "inside transaction " << transaction;
      }
      ASSERT_OK(this->store_.commit());
      committed = model;
    }
    if (transaction % 3 == 0) {
      ASSERT_EQ(contents(this->store_), committed.rows) << "after transaction " << transaction;
    }
  }
  EXPECT_EQ(contents(this->store_), committed.rows);
}

}  // namespace
}  // namespace ilp
