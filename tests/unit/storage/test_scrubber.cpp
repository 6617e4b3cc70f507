#include "fsw/storage/scrubber.hpp"

#include "tests/support/failing_store.hpp"
#include "tests/unit/hal/expect_status.hpp"
#include "tests/unit/shared/component_fixture.hpp"

namespace ilp {
namespace {

constexpr std::size_t image_bytes = 20'000;

class ScrubberTest : public test::ComponentTest {
 protected:
  ScrubberTest() {
    for (std::int64_t id = 1; id <= 5; ++id) {
      FrameRecord frame{.id = id};
      frame.image.bytes = image_bytes;
      write(frame, "image", std::vector<std::uint8_t>(image_bytes, static_cast<std::uint8_t>(id)));
    }
    failing.judge_by([&](const test::FailingStore::Call& call) {
      if (call.kind != test::StoreCall::read_blob) return Status{};
      ++reads;
      if (call.type == RecordType::frame && call.id == damaged_id) {
        return Status{StatusCode::record_damaged, call.id, static_cast<std::int64_t>(call.type)};
      }
      return Status{};
    });
  }
  /// Steps once a second; returns what was reported.
  std::vector<Status> scrub_for(Scrubber& scrubber, int seconds) {
    std::vector<Status> reported;
    for (int i = 0; i < seconds; ++i) {
      clock.set(clock.now() + ns_per_s);
      const StepResult result = scrubber.step();
      EXPECT_FALSE(result.pending) << "a flight in virtual time would go on for it";
      if (!result.status.ok()) reported.push_back(result.status);
    }
    return reported;
  }

  test::FailingStore failing{store};
  std::int64_t damaged_id = 0;
  int reads = 0;
};

TEST_F(ScrubberTest, WhatIsDamagedInTheStoreIsToldOnceHoweverOftenItIsRead) {
  damaged_id = 3;
  mission.scrub_period_s = 10;
  Scrubber scrubber(failing, clock, mission);
  ASSERT_OK(scrubber.restore());
  std::vector<Status> reported = scrub_for(scrubber, 100);
  ASSERT_EQ(reported.size(), 1U);
  EXPECT_EQ(reported[0].code, StatusCode::record_damaged);
  EXPECT_EQ(reported[0].a, 3);
  EXPECT_EQ(reported[0].b, static_cast<std::int64_t>(RecordType::frame));
  EXPECT_GT(reads, 3 * 5) << "it was read again";
  Scrubber after_restart(failing, clock, mission);
  ASSERT_OK(after_restart.restore());
  EXPECT_TRUE(scrub_for(after_restart, 100).empty());
  damaged_id = 4;
  EXPECT_EQ(scrub_for(after_restart, 100).size(), 1U);
}

TEST_F(ScrubberTest, ItKeepsToItsPaceAndRestsBetweenRounds) {
  mission.scrub_bytes_per_s = 10'000;
  mission.scrub_period_s = 1000;
  Scrubber scrubber(failing, clock, mission);
  ASSERT_OK(scrubber.restore());
  scrub_for(scrubber, 5);
  // Four seconds after the first step, with a chunk or record more in each.
  EXPECT_LE(reads, 4 * (10'000 / static_cast<int>(blob_chunk_bytes) + 2));
  EXPECT_GE(reads, 4);
  scrub_for(scrubber, 100);
  const int after_round = reads;
  EXPECT_GE(after_round, 5 * static_cast<int>(image_bytes / blob_chunk_bytes));
  scrub_for(scrubber, 500);
  EXPECT_EQ(reads, after_round);
  scrub_for(scrubber, 1000);
  EXPECT_GT(reads, after_round);
}

TEST_F(ScrubberTest, SwitchedOffItReadsNothing) {
  mission.scrub_bytes_per_s = 0;
  Scrubber scrubber(failing, clock, mission);
  ASSERT_OK(scrubber.restore());
  scrub_for(scrubber, 50);
  EXPECT_EQ(reads, 0);
}

TEST_F(ScrubberTest, AFlippedBitInCodeOrConstantsIsToldAndANewProcessAskedFor) {
  mission.scrub_bytes_per_s = 0;
  std::vector<std::byte> code(100'000, std::byte{0x90}), constants(9'001, std::byte{7});
  const std::span<const std::byte> regions[] = {code, constants};
  for (const std::size_t where : {std::size_t{0}, std::size_t{99'999}, std::size_t{100'000 + 9'000}}) {
    Scrubber scrubber(failing, clock, mission, regions);
    ASSERT_OK(scrubber.restore());
    EXPECT_TRUE(scrub_for(scrubber, 10).empty());
    EXPECT_FALSE(scrubber.image_damaged());
    std::byte& byte = where < code.size() ? code[where] : constants[where - code.size()];
    byte ^= std::byte{0x20};
    const std::vector<Status> reported = scrub_for(scrubber, 10);
    ASSERT_EQ(reported.size(), 1U) << where;
    EXPECT_EQ(reported[0].code, StatusCode::image_damaged);
    EXPECT_EQ(reported[0].a, where < code.size() ? 0 : 1);
    EXPECT_TRUE(scrubber.image_damaged());
    byte ^= std::byte{0x20};
  }
}

}  // namespace
}  // namespace ilp
