// The reading through of a store in slices.
#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "hal/store/forwarding_store.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "hal/store/scrub.hpp"
#include "tests/unit/hal/expect_status.hpp"

namespace ilp {
namespace {

constexpr std::size_t chunk_bytes = 1000;

/// A store whose reads answer what the test wants, and that notes what was read.
struct Witness final : public ForwardingStore {
  Status get_answer;
  std::int64_t damaged_frame = -1, damaged_image = -1;
  bool damaged_strips = false;
  std::set<std::int64_t> frames, images;
  std::size_t image_bytes = 0;

  using ForwardingStore::ForwardingStore;
  Status get(const RecordInfo& info, std::int64_t id, void* record) override {
    if (!get_answer.ok()) return get_answer;
    return inner_.get(info, id, record);
  }
  Status next(const RecordInfo& info, std::int64_t after, void* record) override {
    if (info.type == RecordType::strip && damaged_strips) return StatusCode::store_damaged;
    ILP_TRY(inner_.next(info, after, record));
    if (info.type != RecordType::frame) return {};
    frames.insert(id_of(record));
    return id_of(record) == damaged_frame ? Status{StatusCode::record_damaged, damaged_frame, 1} : Status{};
  }
  Status read_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                   std::span<std::uint8_t> bytes) override {
    if (id == damaged_image) return {StatusCode::record_damaged, id, static_cast<std::int64_t>(info.type)};
    images.insert(id);
    image_bytes += bytes.size();
    return inner_.read_blob(info, field, id, offset, bytes);
  }
};

class Scrub : public testing::Test {
 protected:
  Scrub() {
    EXPECT_OK(store_.begin());
    for (std::int64_t id = 1; id <= 5; ++id) {
      FrameRecord frame{.id = id};
      frame.image.bytes = static_cast<std::uint32_t>(2500 * (id - 1));
      EXPECT_OK(put(store_, frame));
    }
    EXPECT_OK(put(store_, StripRecord{.id = 1}));
    EXPECT_OK(put(store_, KeyframeRecord{}));
    EXPECT_OK(store_.commit());
  }
  /// Slices to the end of a round; what they found.
  std::vector<Status> round(std::size_t max_bytes) {
    std::vector<Status> found;
    for (int slices = 0; slices < 1000; ++slices) {
      const ScrubSlice slice = scrub(store_, max_bytes, scratch_, cursor_);
      EXPECT_LE(slice.bytes, max_bytes + std::max(chunk_bytes, limits::max_record_bytes));
      if (!slice.damage.ok()) found.push_back(slice.damage);
      if (!slice.fault.ok()) found.push_back(slice.fault);
      if (slice.round_complete || !slice.fault.ok()) return found;
    }
    ADD_FAILURE() << "a round that does not end";
    return found;
  }

  std::vector<std::byte> region_ = std::vector<std::byte>(std::size_t{1} << 20U);
  RamStore ram_{region_};
  Witness store_{ram_};
  std::vector<std::uint8_t> scratch_ = std::vector<std::uint8_t>(chunk_bytes);
  ScrubCursor cursor_;
};

TEST_F(Scrub, ReadsEveryRecordAndEveryByteOfBlobsInARoundWhateverTheSlice) {
  for (const std::size_t max_bytes : {1U, 500U, 1000U, 5000U, 1000000U}) {
    store_.frames.clear();
    store_.images.clear();
    store_.image_bytes = 0;
    EXPECT_TRUE(round(max_bytes).empty());
    EXPECT_EQ(store_.frames, (std::set<std::int64_t>{1, 2, 3, 4, 5}));
    EXPECT_EQ(store_.images, (std::set<std::int64_t>{2, 3, 4, 5}));
    EXPECT_EQ(store_.image_bytes, 2500U * (1 + 2 + 3 + 4));
  }
}

TEST_F(Scrub, TellsEachDamageOnceARoundAndReadsOnBehindIt) {
  store_.damaged_frame = 2;
  store_.damaged_image = 4;
  store_.damaged_strips = true;
  for (int again = 0; again < 2; ++again) {
    store_.frames.clear();
    store_.images.clear();
    const std::vector<Status> found = round(3000);
    ASSERT_EQ(found.size(), 3U);
    EXPECT_STATUS(found[0], record_damaged);
    EXPECT_EQ(found[0].a, 2);
    EXPECT_STATUS(found[1], record_damaged);
    EXPECT_EQ(found[1].a, 4);
    EXPECT_STATUS(found[2], store_damaged);
    EXPECT_EQ(store_.frames, (std::set<std::int64_t>{1, 2, 3, 4, 5}));
    EXPECT_EQ(store_.images, (std::set<std::int64_t>{3, 5}));
  }
}

TEST_F(Scrub, AFaultThatPassesIsNoDamageAndNothingIsLeftOut) {
  static_cast<void>(scrub(store_, 1, scratch_, cursor_));
  static_cast<void>(scrub(store_, 400, scratch_, cursor_));
  store_.get_answer = {StatusCode::store_error, 5};
  const std::vector<Status> found = round(3000);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_STATUS(found[0], store_error);
  store_.get_answer = {};
  EXPECT_TRUE(round(3000).empty());
  EXPECT_EQ(store_.image_bytes, 2500U * (1 + 2 + 3 + 4));
}

TEST_F(Scrub, ARecordErasedDuringARoundIsNoDamage) {
  while (cursor_.after != 4 || cursor_.blob == 0) static_cast<void>(scrub(store_, 1, scratch_, cursor_));
  ASSERT_OK(store_.begin());
  ASSERT_OK(store_.erase(record_info<FrameRecord>(), 4));
  ASSERT_OK(store_.commit());
  EXPECT_TRUE(round(3000).empty());
  EXPECT_TRUE(store_.images.contains(5));
}

}  // namespace
}  // namespace ilp
