// Runs one step of a component: checks the component's memory before the step, takes its checksums after the step, and
// follows the step's result.
#pragma once

#include "fsw/executive/component_table.hpp"

namespace ilp {

/// Restores component `i`. If that fails the component waits, which is reported once.
Status restore(ComponentTable& table, std::size_t i);
/// Checks the memory of component `i`, runs its step, and follows the result.
void run_step(ComponentTable& table, std::size_t i);
/// Wakes the components whose input tables have changed, and carries out new commands to restart a component.
void wake(ComponentTable& table);
/// Tries again to take the store's lock if a step has found it taken.
void check_lock(ComponentTable& table);
/// Checks the executive's own state, and repairs it from its copy.
void check_own(ComponentTable& table);

}  // namespace ilp
