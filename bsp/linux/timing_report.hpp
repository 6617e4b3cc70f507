// Prints the durations of minor frames and of the components' steps on standard output.
#pragma once

#include "fsw/executive/executive.hpp"

namespace ilp {

void print_timing(const Executive& executive);

}  // namespace ilp
