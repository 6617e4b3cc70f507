// One life of the software, from a start to its end, on record: why it began and whether it ended in order.
#pragma once

#include "hal/clock/clock.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// What only the board knows of a start.
struct BoardState {
  char boot[sizeof(StartRecord::board)] = {};  ///< another one after every reset; empty where the board has none
  bool watchdog_had_bitten = false;
};

class Life {
 public:
  Life(Store& store, Clock& clock) : store_(store), clock_(clock) {}

  /// Writes the StartRecord, with the reason that the record of the life before and the board tell.
  Status begin(const BoardState& board);
  /// To be called now and then: what a sudden end leaves behind. `record` has its counts from the caller.
  Status go_on();
  /// The end was ordered.
  Status end();

  [[nodiscard]] StartRecord& record() { return record_; }

 private:
  Status write();

  Store& store_;
  Clock& clock_;
  StartRecord record_;
};

}  // namespace ilp
