// Prints the durations of minor frames and components in short lines on standard output.
#pragma once

#include "fsw/executive/executive.hpp"

namespace ilp {

void print_timing(const Executive& executive);

}  // namespace ilp
