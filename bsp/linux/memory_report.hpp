// Prints the static memory of the flight binary, and a flight's use of it, in short lines on standard output.
#pragma once

#include "bsp/flight/flight_store.hpp"

namespace ilp {

/// Prints every static region; the total is the writable memory of the binary.
void print_memory_map();
/// Prints the use of heap, store and stack so far.
void print_memory_use(const FlightStore& store);

}  // namespace ilp
