// Runs the components in a minor frame: decides which one steps next.
#pragma once

#include "fsw/executive/component_table.hpp"

namespace ilp {

/// Runs every due component and every woken one once, in the order of the table, then pending work as long as it fits
/// before `end`.
void run_components(ComponentTable& table, TimeNs end);

}  // namespace ilp
