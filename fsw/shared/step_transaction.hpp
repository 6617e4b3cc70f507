// The transaction of a step that writes: records, cursor and state are committed together; memory is updated
// afterwards.
#pragma once

#include "fsw/shared/checkpoint.hpp"

namespace ilp {

/// A step calls begin(), writes its records, and calls commit(), which also saves the checkpoint. Cursor and state
/// change in memory only after the store has committed them: a process may end at any instruction, and a bit that
/// flipped during the step is noticed at the commit (fsw/executive/step_store.hpp). Without commit() everything is
/// rolled back.
class StepTransaction : private Transaction {
 public:
  StepTransaction(CheckpointStore store, const CheckpointForm& form) : Transaction(store), store_(store), form_(form) {}

  using Transaction::begin;
  /// commit() without arguments leaves the checkpoint as it is: for records that contain the component's progress.
  using Transaction::commit;

  /// Commits the records with `after_cursor` and `after`, then copies these to `cursor` and `state`.
  template <typename State>
  Status commit(const Cursor& after_cursor, State& after, Cursor& cursor, State& state) {
    ILP_TRY(commit(after_cursor, after, cursor));
    state = after;
    return {};
  }
  /// As above without the copy of the state, for a component that has changed its state in place or does not keep it in
  /// memory.
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
