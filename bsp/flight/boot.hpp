// The record of one boot of the software, from its start to its end: the reason for its start, and whether it ended in
// order.
#pragma once

#include "hal/clock/clock.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// Facts of a start that only the board knows.
struct BoardState {
  char boot[sizeof(StartRecord::board)] = {};  ///< changes with every reset; empty if the board has none
  bool watchdog_had_bitten = false;
};

class Boot {
 public:
  Boot(Store& store, Clock& clock) : store_(store), clock_(clock) {}

  /// Writes the StartRecord, with the reason that follows from the previous boot's record and from the board.
  Status begin(const BoardState& board);
  /// Call it regularly: it writes what a sudden end leaves on record. `record` has its counts from the caller.
  Status go_on();
  /// The end was commanded.
  Status end();

  [[nodiscard]] StartRecord& record() { return record_; }

 private:
  Status write();

  Store& store_;
  Clock& clock_;
  StartRecord record_;
};

}  // namespace ilp
