// The executive's housekeeping: times of minor frames, the work level, and statistics of components.
#pragma once

#include "fsw/executive/component_table.hpp"

namespace ilp {

/// Loads the work level of the previous boot, and skips earlier commands to restart components.
Status take_up(ComponentTable& table);
/// Counts a frame that should have begun at `nominal` and began at `begin`, and writes housekeeping if it is due.
void end_frame(ComponentTable& table, TimeNs nominal, TimeNs begin);
/// Writes one ComponentRecord per component, and the TimingRecord.
Status write_housekeeping(ComponentTable& table);

}  // namespace ilp
