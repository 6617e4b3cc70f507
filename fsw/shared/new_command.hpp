// Commands are the one kind of record that several components make.
#pragma once

#include "hal/store/newest_id.hpp"

namespace ilp {

/// Numbers `command` on from the newest one and writes it. To be called in the transaction of a step: components step
/// one after the other, so that no two commands get the same number.
inline Status put_new_command(StorePart<Writes<CommandRecord>> store, CommandRecord& command) {
  ILP_TRY(newest_id<CommandRecord>(store, command.id));
  ++command.id;
  return put(store, command);
}

}  // namespace ilp
