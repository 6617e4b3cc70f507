// The frame of a step that writes: records, cursor and state in one transaction, and memory after it.
#pragma once

#include "fsw/shared/checkpoint.hpp"

namespace ilp {

/// begin(), the writes of the step, then commit(), which saves the checkpoint with them. Cursor and state change in
/// memory after the store has taken them, and not before: a process may end at any instruction, and a bit that flipped
/// during the step is noticed at the commit (fsw/executive/step_store.hpp). Without commit() everything is rolled back.
class StepTransaction : private Transaction {
 public:
  StepTransaction(CheckpointStore store, const CheckpointForm& form) : Transaction(store), store_(store), form_(form) {}

  using Transaction::begin;
  /// For records that carry their own progress: the checkpoint stays as it is.
  using Transaction::commit;

  template <typename State>
  Status commit(const Cursor& after_cursor, State& after, Cursor& cursor, State& state) {
    ILP_TRY(commit(after_cursor, after, cursor));
    state = after;
    return {};
  }
  /// For a state that the component has in place already, or that is not kept in memory.
  template <typename State>
  Status commit(const Cursor& after_cursor, State& after, Cursor& cursor) {
    ILP_TRY(save_checkpoint(store_, form_, after_cursor, after));
    ILP_TRY(Transaction::commit());
    cursor = after_cursor;
    return {};
  }

 private:
  CheckpointStore store_;
  const CheckpointForm& form_;
};

}  // namespace ilp
