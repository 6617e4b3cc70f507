// Writes the record of one boot of the software (StartRecord): the reason for its start, and whether it ended in order.
#pragma once

#include "hal/clock/clock.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// Facts of a start that only the board knows.
struct BoardState {
  char boot[sizeof(StartRecord::board)] = {};  ///< identifier that changes with every reset of the board; empty: none
  bool watchdog_had_bitten = false;            ///< the watchdog caused the latest reset
};

class Boot {
 public:
  Boot(Store& store, Clock& clock) : store_(store), clock_(clock) {}

  /// Writes a new StartRecord. The reason of the start follows from the record of the previous boot and from the board.
  Status begin(const BoardState& board);
  /// Writes the record with the present time as the latest known time of the boot. Call it regularly, because a sudden
  /// end leaves this record.
  Status go_on();
  /// Writes the record with the end, for a boot that ends in order.
  Status end();

  /// The record; the caller sets its counts before go_on() or end().
  [[nodiscard]] StartRecord& record() { return record_; }

 private:
  Status write();

  Store& store_;
  Clock& clock_;
  StartRecord record_;
};

}  // namespace ilp
