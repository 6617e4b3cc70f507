// A process of a flight that runs some of its stages, without camera and links (docs/several-machines.md).
#pragma once

#include <csignal>

#include "bsp/flight/flight_software.hpp"
#include "bsp/linux/chosen_store.hpp"
#include "bsp/linux/options.hpp"

namespace ilp {

/// The static memory that a flight and a node use alike.
struct FlightPlace {
  ChosenStore& store;
  void* software;  ///< for a FlightSoftware
};

/// Waits for the primary, runs the stages until the flight has ended or `stop` is set, and returns the program's exit
/// status: 0 in order; 1 if the process may not take part; 3 if it should be started again.
int run_node(const Options& options, StageMask stages, const FlightPlace& place,
             const volatile std::sig_atomic_t& stop);

}  // namespace ilp
