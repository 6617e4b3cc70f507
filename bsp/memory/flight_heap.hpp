// The malloc family of a flight binary: fixed regions instead of a heap (architecture, "Memory").
//
// A binary that links ilp_flight_heap has no other malloc. Until seal_heap() the `early` region serves all requests
// (the C library's start-up, stdio, threads). A HeapGateScope opens the region that it names, for its thread; one
// thread at a time has a region open. After sealing, any other request is a trap: counted, reported on standard error,
// and refused. Start-up is single-threaded.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fsw/base/heap_gate.hpp"

namespace ilp {

enum class HeapTrapMode : std::uint8_t {
  report,  ///< the request gets nullptr and the program continues
  strict   ///< the program aborts: for the test that a flight allocates nothing
};

/// Call it once, at the end of start-up.
void seal_heap(HeapTrapMode mode);
/// Requests refused since sealing.
[[nodiscard]] std::uint64_t heap_trap_count();

struct HeapRegionReport {
  const char* name = "";
  std::size_t bytes = 0;
  std::size_t in_use = 0;
  std::size_t peak = 0;        ///< largest in_use
  std::size_t high_water = 0;  ///< the smallest region that would have sufficed
  std::uint64_t requests = 0;
  std::uint64_t failed = 0;
};
/// One row of the memory map.
[[nodiscard]] HeapRegionReport heap_region_report(HeapRegion region);

/// For tests: request `nth` (from 1) after the next opening of the gate finds the region exhausted. 0 switches the
/// fault off.
void set_heap_fault(std::uint64_t nth);

}  // namespace ilp
