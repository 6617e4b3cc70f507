#include "fsw/shared/checkpoint.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <new>
#include <vector>

#include "hal/store/ram/ram_store.hpp"
#include "tests/support/store_records.hpp"
#include "tests/unit/hal/expect_status.hpp"

namespace ilp {
// Named, because the compiler looks at the fields of structs with linkage only.
namespace checkpoint_test {

struct Small {
  std::int64_t value = 0;
};
struct Large {
  std::int64_t values[4] = {};
};

struct Renamed {
  std::int64_t utility = 0;
};
struct Padded {
  bool yes;
  std::int64_t value;
};

constexpr ComponentId component = ComponentId::dense_matcher;

class CheckpointTest : public testing::Test {
 protected:
  void save(const CheckpointForm& form, Small state) {
    test::in_transaction(store_, [&] { ASSERT_OK(save_checkpoint(store_, form, {5, 6}, state)); });
  }

  CheckpointRecord row(std::int64_t id) {
    CheckpointRecord record;
    EXPECT_OK(get(store_, id, record));
    return record;
  }
  /// One bit of the state in a row, as a disk or a memory would change it.
  void flip_state(std::int64_t id) {
    std::uint8_t byte = 0;
    Transaction transaction(store_);
    ASSERT_OK(transaction.begin());
    ASSERT_OK(read_blob<CheckpointRecord>(store_, "state", id, 3, {&byte, 1}));
    byte ^= 0x10U;
    ASSERT_OK(write_blob<CheckpointRecord>(store_, "state", id, 3, {&byte, 1}));
    ASSERT_OK(transaction.commit());
  }
  void flip_cursor(std::int64_t id) {
    CheckpointRecord record = row(id);
    record.cursor ^= 1;
    test::write_records(store_, record);
  }
  Status save_at(const Cursor& cursor, std::int64_t value) {
    Transaction transaction(store_);
    ILP_TRY(transaction.begin());
    Small state{value};
    ILP_TRY(save_checkpoint(store_, small_form, cursor, state));
    return transaction.commit();
  }
  std::int64_t loaded_value(StatusCode expected) {
    Small state{-1};
    EXPECT_EQ(restore_checkpoint(store_, small_form, cursor_, state).code, expected);
    return state.value;
  }

  static constexpr CheckpointForm small_form = checkpoint_form<Small>(component, 2);
  static constexpr std::int64_t first_row = static_cast<std::int64_t>(component), second_row = first_row + 100;
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

TEST_F(CheckpointTest, OneOfAnotherBuildIsNoReasonToStartOver) {
  save(checkpoint_form<Small>(component, 2), {42});
  Small same;
  Large larger;
  EXPECT_STATUS(restore_checkpoint(store_, checkpoint_form<Small>(component, 3), cursor_, same), store_build);
  const Status refused = restore_checkpoint(store_, checkpoint_form<Large>(component, 2), cursor_, larger);
  EXPECT_STATUS(refused, store_build);
  EXPECT_EQ(refused.b, static_cast<std::int64_t>(sizeof(Small))) << "what is in the store";
}

TEST_F(CheckpointTest, AFormFollowsFromTheFields) {
  save(checkpoint_form<Small>(component, 2), {42});
  Renamed renamed;
  EXPECT_STATUS(restore_checkpoint(store_, checkpoint_form<Renamed>(component, 2), cursor_, renamed), store_build);
  EXPECT_EQ(checkpoint_form<Small>(component, 2).layout >> 24U, 2U) << "the number of the row";
}

TEST_F(CheckpointTest, ThePaddingOfAStateIsZero) {
  alignas(Padded) std::uint8_t memory[sizeof(Padded)];
  std::fill(std::begin(memory), std::end(memory), std::uint8_t{0xA5});
  auto& state = *new (memory) Padded;
  state.yes = true;
  state.value = 7;
  test::in_transaction(store_, [&] {
    ASSERT_OK(save_checkpoint(store_, checkpoint_form<Padded>(component, 2), {5, 6}, state));
  });
  std::uint8_t stored[sizeof(Padded)] = {};
  ASSERT_OK(read_blob<CheckpointRecord>(store_, "state", first_row, 0, stored));
  const std::uint8_t expected[] = {1, 0, 0, 0, 0, 0, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0};
  EXPECT_TRUE(std::equal(std::begin(stored), std::end(stored), std::begin(expected)));
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

TEST_F(CheckpointTest, TwoGenerationsAreKeptAndTheNewerOneIsLoaded) {
  for (std::int64_t i = 1; i <= 5; ++i) ASSERT_OK(save_at({i, 0}, 10 * i));
  EXPECT_EQ(row(first_row).cursor, 5);
  EXPECT_EQ(row(second_row).cursor, 4);
  EXPECT_EQ(loaded_value(StatusCode::ok), 50);
  EXPECT_EQ(cursor_.first, 5);
}

TEST_F(CheckpointTest, WhereTheNewerOneIsDamagedTheOlderOneIsLoadedAndSavingGoesOnFromThere) {
  for (const bool in_state : {true, false}) {
    SCOPED_TRACE(in_state);
    ASSERT_OK(save_at({7, 0}, 70));
    ASSERT_OK(save_at({8, 0}, 80));
    const std::int64_t newer = row(first_row).cursor == 8 ? first_row : second_row;
    if (in_state) flip_state(newer);
    if (!in_state) flip_cursor(newer);
    EXPECT_EQ(loaded_value(StatusCode::checkpoint_older), 70);
    EXPECT_EQ(cursor_.first, 7);
    EXPECT_EQ(loaded_value(StatusCode::ok), 70) << "told once";
    // The step is done again.
    ASSERT_OK(save_at({8, 0}, 81));
    EXPECT_EQ(loaded_value(StatusCode::ok), 81);
    store_.~RamStore();
    new (&store_) RamStore(memory_);
  }
}

TEST_F(CheckpointTest, WhereTheOlderOneIsDamagedTheNewerOneIsLoaded) {
  ASSERT_OK(save_at({7, 0}, 70));
  ASSERT_OK(save_at({8, 0}, 80));
  flip_state(row(first_row).cursor == 7 ? first_row : second_row);
  EXPECT_EQ(loaded_value(StatusCode::ok), 80) << "nobody looks at the other one";
  ASSERT_OK(save_at({9, 0}, 90));
  EXPECT_EQ(loaded_value(StatusCode::ok), 90);
}

TEST_F(CheckpointTest, WhereBothAreDamagedItIsSaidAndNothingOfThemIsBelieved) {
  ASSERT_OK(save_at({7, 0}, 70));
  ASSERT_OK(save_at({8, 0}, 80));
  flip_state(first_row);
  flip_cursor(second_row);
  EXPECT_EQ(loaded_value(StatusCode::checkpoint_lost), 0);
  EXPECT_EQ(cursor_.first, 0);
  EXPECT_EQ(loaded_value(StatusCode::ok), 0) << "told once";
}

TEST_F(CheckpointTest, WhereTheNewerOneIsDamagedOneOfTheFormBeforeIsOfNoUseAndInNobodysWay) {
  constexpr CheckpointForm before = checkpoint_form<Small>(component, 1);
  save(before, {10});
  ASSERT_OK(save_at({8, 9}, 80));
  flip_state(row(first_row).layout == 2 ? first_row : second_row);
  EXPECT_EQ(loaded_value(StatusCode::checkpoint_lost), 0);
  EXPECT_EQ(loaded_value(StatusCode::ok), 0) << "a flight that goes on from there can be started again";
}

TEST_F(CheckpointTest, ACursorInTheStoreNeverGoesBack) {
  ASSERT_OK(save_at({7, 3}, 70));
  ASSERT_OK(save_at({8, 3}, 80));
  EXPECT_STATUS(save_at({7, 3}, 1), cursor_back);
  EXPECT_STATUS(save_at({0, 0}, 1), cursor_back);
  EXPECT_STATUS(save_at({9, 2}, 1), cursor_back);
  EXPECT_EQ(loaded_value(StatusCode::ok), 80) << "nothing was written";
  EXPECT_OK(save_at({8, 3}, 81));
}

TEST_F(CheckpointTest, HowFarAComponentHasComeIsReadFromTheNewerOne) {
  Cursor cursor{9, 9};
  EXPECT_OK(saved_cursor(store_, component, cursor));
  EXPECT_EQ(cursor.first, 0);
  for (std::int64_t i = 1; i <= 4; ++i) {
    ASSERT_OK(save_at({i, 2 * i}, 0));
    EXPECT_OK(saved_cursor(store_, component, cursor));
    EXPECT_EQ(cursor.first, i);
    EXPECT_EQ(cursor.second, 2 * i);
  }
}

}  // namespace checkpoint_test
}  // namespace ilp
