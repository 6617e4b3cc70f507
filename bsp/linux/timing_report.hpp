// What minor frames and components took, in short lines on standard output.
#pragma once

#include "fsw/executive/executive.hpp"

namespace ilp {

void print_timing(const Executive& executive);

}  // namespace ilp
