#include "fsw/components/checkpoint.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "hal/store/ram/ram_store.hpp"
#include "tests/unit/hal/expect_status.hpp"

namespace ilp {
namespace {

struct Small {
  std::int64_t value = 0;
};
struct Large {
  std::int64_t values[4] = {};
};

constexpr ComponentId component = ComponentId::dense_matcher;

class CheckpointTest : public testing::Test {
 protected:
  void save(const CheckpointForm& form, const Small& state) {
    Transaction transaction(store_);
    ASSERT_OK(transaction.begin());
    ASSERT_OK(save_checkpoint(store_, form, {5, 6}, state));
    ASSERT_OK(transaction.commit());
  }

  std::vector<std::byte> memory_ = std::vector<std::byte>(1U << 20U);
  RamStore store_{memory_};
  Cursor cursor_{1, 1};
};

TEST_F(CheckpointTest, CursorAndStateComeBackAsTheyWereAndAreNewWhereThereIsNone) {
  constexpr CheckpointForm form = checkpoint_form<Small>(component, 2);
  Small state{7};
  EXPECT_OK(restore_checkpoint(store_, form, cursor_, state));
  EXPECT_EQ(cursor_.first, 0);
  EXPECT_EQ(state.value, 0);
  save(form, {42});
  EXPECT_OK(restore_checkpoint(store_, form, cursor_, state));
  EXPECT_EQ(cursor_.first, 5);
  EXPECT_EQ(cursor_.second, 6);
  EXPECT_EQ(state.value, 42);
}

TEST_F(CheckpointTest, OneOfAnotherBuildIsNoReasonToBeginAnew) {
  save(checkpoint_form<Small>(component, 2), {42});
  Small same;
  Large larger;
  EXPECT_STATUS(restore_checkpoint(store_, checkpoint_form<Small>(component, 3), cursor_, same), store_build);
  const Status refused = restore_checkpoint(store_, checkpoint_form<Large>(component, 2), cursor_, larger);
  EXPECT_STATUS(refused, store_build);
  EXPECT_EQ(refused.b, static_cast<std::int64_t>(sizeof(Small))) << "what is in the store";
}

TEST_F(CheckpointTest, AComponentWithSeveralFormsMayHaveAnyOfThem) {
  constexpr CheckpointForm small = checkpoint_form<Small>(component, 1), large = checkpoint_form<Large>(component, 2);
  constexpr CheckpointForm other = checkpoint_form<Large>(ComponentId::downlink, 1);
  save(small, {42});
  const CheckpointForm* const both[] = {&large, &other, &small};
  const CheckpointForm* const one[] = {&large, &other};
  const CheckpointForm* const others[] = {&other};
  EXPECT_OK(check_checkpoints(store_, both));
  EXPECT_STATUS(check_checkpoints(store_, one), store_build);
  EXPECT_OK(check_checkpoints(store_, others)) << "nobody asks for it";
}

}  // namespace
}  // namespace ilp
