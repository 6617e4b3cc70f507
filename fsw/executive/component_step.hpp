// One step of a component: its memory is checked before and sealed after it, and what its result asks for is done.
#pragma once

#include "fsw/executive/component_table.hpp"

namespace ilp {

/// Restores component `i`. Reports it once if the component has to wait.
Status restore(ComponentTable& table, std::size_t i);
/// Checks the memory of component `i`, lets it step, and does what the result asks for.
void run_step(ComponentTable& table, std::size_t i);
/// Wakes those whose records have changed.
void wake(ComponentTable& table);
/// A lock of the store that a step has found taken is tried again.
void check_lock(ComponentTable& table);
void check_own(ComponentTable& table);

}  // namespace ilp
