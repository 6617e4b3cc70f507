// What the executive writes about itself: times of minor frames, the level of work, numbers of its components.
#pragma once

#include "fsw/executive/component_table.hpp"

namespace ilp {

/// Continues numbers and level of the previous boot.
Status take_up(ComponentTable& table);
/// Counts a frame that began at `begin` instead of at `nominal`, and writes what is due.
void end_frame(ComponentTable& table, TimeNs nominal, TimeNs begin);
/// One ComponentRecord per component, and the TimingRecord.
Status write_housekeeping(ComponentTable& table);

}  // namespace ilp
