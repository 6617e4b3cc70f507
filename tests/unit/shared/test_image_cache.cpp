// Images at hand: fewer readings of the store, and never another answer than the store's.

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <vector>

#include "fsw/shared/image_cache.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "tests/support/failing_store.hpp"

namespace ilp {
namespace {

using test::FailingStore;
using test::StoreCall;

class ImageCacheTest : public testing::Test {
 protected:
  ImageCacheTest() {
    store_.judge_by([this](const FailingStore::Call& call) {
      reads_ += call.kind == StoreCall::read_blob ? 1 : 0;
      return Status{};
    });
  }

  Status begin_frame(std::int64_t id, std::uint8_t grey) {
    ILP_TRY(cache_->begin());
    FrameRecord frame{.id = id};
    frame.image.bytes = bytes_;
    ILP_TRY(put(*cache_, frame));
    return write_blob<FrameRecord>(*cache_, "image", id, 0, std::vector<std::uint8_t>(bytes_, grey));
  }
  void write(std::int64_t id, std::uint8_t grey) {
    ASSERT_TRUE(begin_frame(id, grey).ok());
    ASSERT_TRUE(cache_->commit().ok());
  }
  /// The image is all of this grey value.
  testing::AssertionResult reads_as(std::int64_t id, std::uint8_t grey) {
    std::vector<std::uint8_t> image(bytes_);
    const Status read = read_blob<FrameRecord>(*cache_, "image", id, 0, image);
    if (!read.ok()) return testing::AssertionFailure() << status_name(read.code);
    return image == std::vector<std::uint8_t>(bytes_, grey) ? testing::AssertionSuccess() : testing::AssertionFailure();
  }

  static constexpr std::uint32_t bytes_ = 6400;
  std::vector<std::byte> region_ = std::vector<std::byte>(std::size_t{4} << 20U);
  RamStore ram_{region_};
  FailingStore store_{ram_};
  std::unique_ptr<ImageCache> cache_ = std::make_unique<ImageCache>(store_);
  int reads_ = 0;
};

TEST_F(ImageCacheTest, AnImageThatWasJustWrittenIsNotReadAtAll) {
  write(1, 10);
  EXPECT_TRUE(reads_as(1, 10));
  EXPECT_EQ(reads_, 0);
}

TEST_F(ImageCacheTest, NewFramesDoNotPushOutTheImagesAtWork) {
  write(1, 10);
  write(2, 20);
  EXPECT_TRUE(reads_as(1, 10));
  for (std::int64_t id = 3; id < 20; ++id) write(id, 30);
  EXPECT_TRUE(reads_as(1, 10));
  EXPECT_EQ(reads_, 1);
}

TEST_F(ImageCacheTest, TheImageThatWasUsedLongestAgoGivesItsPlace) {
  const auto most = static_cast<std::int64_t>(limits::cached_images);
  for (std::int64_t id = 1; id <= most + 2; ++id) write(id, static_cast<std::uint8_t>(id));
  for (std::int64_t id = 1; id <= most + 1; ++id) EXPECT_TRUE(reads_as(id, static_cast<std::uint8_t>(id)));
  EXPECT_EQ(reads_, most + 1);
  EXPECT_TRUE(reads_as(2, 2));
  EXPECT_EQ(reads_, most + 1) << "it is at hand";
  EXPECT_TRUE(reads_as(1, 1));
  EXPECT_EQ(reads_, most + 2) << "it has made room";
}

TEST_F(ImageCacheTest, WhatWasNotCommittedIsNotAtHand) {
  write(1, 10);
  ASSERT_TRUE(begin_frame(1, 20).ok());
  cache_->rollback();
  EXPECT_TRUE(reads_as(1, 10));
  EXPECT_EQ(reads_, 1);
  ASSERT_TRUE(begin_frame(1, 30).ok());
  store_.fail(store_.calls());
  EXPECT_FALSE(cache_->commit().ok());
  store_.recover();
  EXPECT_TRUE(reads_as(1, 10));
}

TEST_F(ImageCacheTest, AnImageThatIsReleasedOrErasedIsGoneAtOnce) {
  write(1, 10);
  write(2, 20);
  FrameRecord released{.id = 1};
  ASSERT_TRUE(cache_->begin().ok());
  ASSERT_TRUE(put(*cache_, released).ok());
  ASSERT_TRUE(cache_->erase(record_info<FrameRecord>(), 2).ok());
  ASSERT_TRUE(cache_->commit().ok());
  EXPECT_FALSE(reads_as(1, 10));
  EXPECT_FALSE(reads_as(2, 20));
}

TEST_F(ImageCacheTest, ADamagedImageIsNoticedWhereTheStoreIsRead) {
  write(1, 10);
  write(2, 20);
  store_.recover();
  store_.damage(RecordType::frame, 1);
  std::vector<std::uint8_t> image(bytes_);
  EXPECT_TRUE(read_blob<FrameRecord>(*cache_, "image", 1, 0, image).is(StatusCode::record_damaged));
  EXPECT_TRUE(reads_as(2, 20));
}

TEST_F(ImageCacheTest, AFlippedBitInMemoryIsNeverGivenOut) {
  write(1, 123);
  auto* const memory = reinterpret_cast<std::uint8_t*>(cache_.get());
  auto* const pixel = static_cast<std::uint8_t*>(std::memchr(memory + 64, 123, sizeof(ImageCache) - 64));
  ASSERT_NE(pixel, nullptr);
  // Somewhere in the middle of the image.
  pixel[bytes_ / 2] ^= 4;
  EXPECT_TRUE(reads_as(1, 123));
  EXPECT_EQ(reads_, 1);
}

TEST_F(ImageCacheTest, PartsOfAnImageAndOtherTablesComeFromTheStore) {
  write(1, 10);
  std::vector<std::uint8_t> part(100);
  EXPECT_TRUE(read_blob<FrameRecord>(*cache_, "image", 1, 50, part).ok());
  EXPECT_TRUE(read_blob<FrameRecord>(*cache_, "image", 1, 0, part).ok());
  EXPECT_EQ(reads_, 2);
  EXPECT_TRUE(reads_as(1, 10));
}

}  // namespace
}  // namespace ilp
