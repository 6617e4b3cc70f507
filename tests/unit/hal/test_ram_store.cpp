// What the store in memory promises beyond the contract: a full region, and that nothing leaks.
#include <gtest/gtest.h>

#include <vector>

#include "hal/store/ram/ram_store.hpp"
#include "tests/unit/hal/expect_status.hpp"

namespace ilp {
namespace {

using Bytes = std::vector<std::uint8_t>;

FrameRecord frame_of(std::int64_t id, std::uint32_t image_bytes) {
  FrameRecord frame{.id = id};
  frame.image.bytes = image_bytes;
  return frame;
}

Status put_now(Store& store, const FrameRecord& frame, std::uint8_t value) {
  Transaction transaction(store);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(store, frame));
  ILP_TRY(write_blob<FrameRecord>(store, "image", frame.id, 0, Bytes(frame.image.bytes, value)));
  return transaction.commit();
}

TEST(RamStore, FullRegionIsAStatusAndLeavesWhatWasCommitted) {
  // Every size of region, so that every allocation of the second transaction is refused once.
  for (std::size_t bytes = 2000; bytes < 16000; bytes += 48) {
    std::vector<std::byte> region(bytes);
    RamStore store(region);
    if (!put_now(store, frame_of(1, 500), 1).ok()) continue;
    const std::size_t in_use = store.memory().in_use;
    ASSERT_OK(store.begin());
    Status status = put(store, frame_of(1, 2500));
    for (std::int64_t id = 2; status.ok() && id < 4; ++id) status = put(store, frame_of(id, 1500));
    if (status.ok()) status = write_blob<FrameRecord>(store, "image", 2, 0, Bytes(10, 2));
    if (status.ok()) status = store.erase(record_info<FrameRecord>(), 3);
    if (!status.ok()) {
      EXPECT_EQ(status.code, StatusCode::store_full);
      EXPECT_EQ(status.b, static_cast<std::int64_t>(store.memory().capacity));
      EXPECT_STATUS(put(store, frame_of(9, 0)), store_full) << "a doomed transaction takes no more";
      EXPECT_STATUS(store.commit(), store_full);
    } else {
      store.rollback();
    }
    // Only the index of the table may have grown.
    EXPECT_LE(store.memory().in_use, in_use + 512) << "rolled back, yet not released";
    std::int64_t records = 0;
    ASSERT_OK(store.count(record_info<FrameRecord>(), records));
    EXPECT_EQ(records, 1);
    Bytes image(500);
    ASSERT_OK(read_blob<FrameRecord>(store, "image", 1, 0, image));
    EXPECT_EQ(image, Bytes(500, 1));
    EXPECT_OK(put_now(store, frame_of(1, 500), 3)) << "the store goes on";
  }
}

TEST(RamStore, NothingLeaks) {
  std::vector<std::byte> region(200000);
  RamStore store(region);
  ASSERT_OK(put_now(store, frame_of(1, 1000), 1));
  ASSERT_OK(put_now(store, frame_of(2, 1000), 1));
  const std::size_t in_use = store.memory().in_use;
  for (int round = 0; round < 3000; ++round) {
    ASSERT_OK(store.begin());
    ASSERT_OK(store.erase(record_info<FrameRecord>(), 1));
    ASSERT_OK(put(store, frame_of(1, 900)));
    ASSERT_OK(put(store, frame_of(1, 1000)));
    ASSERT_OK(write_blob<FrameRecord>(store, "image", 1, 0, Bytes(1000, 2)));
    ASSERT_OK(write_blob<FrameRecord>(store, "image", 2, 10, Bytes(10, 2)));
    ASSERT_OK(put(store, frame_of(2, 1000)));
    ASSERT_OK(put(store, frame_of(3, 50)));
    ASSERT_OK(store.erase(record_info<FrameRecord>(), 3));
    if (round % 2 == 0) {
      ASSERT_OK(store.commit());
    } else {
      store.rollback();
    }
    // The arena may leave a few bytes too small to be a block of their own with their neighbour.
    ASSERT_LE(store.memory().in_use, in_use + 256) << "round " << round;
  }
  EXPECT_EQ(store.memory().misuse, 0U) << "released twice";
}

}  // namespace
}  // namespace ilp
