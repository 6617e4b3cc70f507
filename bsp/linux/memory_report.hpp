// Static memory of the flight binary, and what a flight used of it, in short lines on standard output.
#pragma once

#include "bsp/flight/flight_store.hpp"

namespace ilp {

/// Every static region; the total is what is writable in the binary.
void print_memory_map();
/// Heap, store and stack so far.
void print_memory_use(const FlightStore& store);

}  // namespace ilp
