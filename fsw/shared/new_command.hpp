// Writes a new command record. Commands are the only records that several components make.
#pragma once

#include "hal/store/newest_id.hpp"

namespace ilp {

/// Gives `command` the id after that of the newest command, and writes it. Call it in the transaction of a step: steps
/// do not overlap, so that no two commands get the same id.
inline Status put_new_command(StorePart<Writes<CommandRecord>> store, CommandRecord& command) {
  ILP_TRY(newest_id<CommandRecord>(store, command.id));
  ++command.id;
  return put(store, command);
}

}  // namespace ilp
