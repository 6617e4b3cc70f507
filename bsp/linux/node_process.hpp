// Runs a process of a flight that has some of its stages, but no camera and no links (docs/several-machines.md).
#pragma once

#include <csignal>

#include "bsp/flight/flight_software.hpp"
#include "bsp/linux/chosen_store.hpp"
#include "bsp/linux/options.hpp"

namespace ilp {

/// Static memory of the program, which either a primary or a node uses.
struct FlightPlace {
  ChosenStore& store;
  void* software;  ///< memory for a FlightSoftware
};

/// Waits for the primary and runs the stages until the flight has ended or `stop` is set. Returns the exit status of
/// the program: 0 after an ordered end, 1 if the process may not join the flight, 3 if it should be started again.
int run_node(const Options& options, StageMask stages, const FlightPlace& place,
             const volatile std::sig_atomic_t& stop);

}  // namespace ilp
