// Prints the static memory of the flight program and how much of it a flight uses, on standard output.
#pragma once

#include "bsp/flight/flight_store.hpp"

namespace ilp {

/// Prints every static region, and the total of the program's writable memory.
void print_memory_map();
/// Prints the use of heap, store and stack until now.
void print_memory_use(const FlightStore& store);

}  // namespace ilp
