// Which component steps next in a minor frame.
#pragma once

#include "fsw/executive/component_table.hpp"

namespace ilp {

/// Every due component once in table order and woken ones between them, then pending work as long as it fits before
/// `end`.
void run_components(ComponentTable& table, TimeNs end);

}  // namespace ilp
