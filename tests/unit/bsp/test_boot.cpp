#include "bsp/flight/boot.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "cfg/limits.hpp"
#include "fsw/base/text.hpp"
#include "hal/clock/virtual_clock.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "tests/support/store_records.hpp"

namespace ilp {
namespace {

class BootTest : public testing::Test {
 protected:
  static BoardState board(const char* boot, bool bitten = false) {
    BoardState state;
    copy_text(state.boot, boot);
    state.watchdog_had_bitten = bitten;
    return state;
  }
  StartReason begin(const BoardState& state) {
    clock_.sleep_until(clock_.now() + ns_per_s);
    Boot boot(store_, clock_);
    EXPECT_TRUE(boot.begin(state).ok());
    boot_ = boot.record();
    return boot_.reason;
  }
  void end() {
    Boot boot(store_, clock_);
    boot.record() = boot_;
    EXPECT_TRUE(boot.end().ok());
  }

  std::vector<std::byte> memory_ = std::vector<std::byte>(std::size_t{1} << 20U);
  RamStore store_{memory_};
  VirtualClock clock_;
  StartRecord boot_;
};

TEST_F(BootTest, TheReasonOfEveryStartIsOnRecord) {
  EXPECT_EQ(begin(board("one")), StartReason::first);
  end();
  EXPECT_EQ(begin(board("one")), StartReason::stopped);
  EXPECT_EQ(begin(board("one")), StartReason::process_died);
  EXPECT_EQ(begin(board("two")), StartReason::board_reset);
  EXPECT_EQ(begin(board("three", true)), StartReason::watchdog);
  EXPECT_EQ(begin(board("")), StartReason::board_reset) << "a board without names for its boots";
  EXPECT_EQ(begin(board("")), StartReason::board_reset) << "two boots without names are not the same";
  end();
  EXPECT_EQ(begin(board("four", true)), StartReason::stopped) << "an old bite, from before the ordered stop";
}

TEST_F(BootTest, AnEndAtMissionTimeZeroIsAnEnd) {
  Boot boot(store_, clock_);
  ASSERT_TRUE(boot.begin({}).ok());
  ASSERT_TRUE(boot.end().ok());
  EXPECT_EQ(begin({}), StartReason::stopped);
}

TEST_F(BootTest, OnlyTheNewestBootsStay) {
  StartRecord record{.id = limits::max_starts};
  test::write_records(store_, record);
  record.id = 1;
  test::write_records(store_, record);
  begin({});
  EXPECT_EQ(boot_.id, limits::max_starts + 1);
  EXPECT_TRUE(get(store_, 1, record).is(StatusCode::not_found));
}

}  // namespace
}  // namespace ilp
