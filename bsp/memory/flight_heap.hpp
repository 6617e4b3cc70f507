// The malloc family of a flight program: fixed regions in place of a heap (docs/budgets.md, "Memory").
//
// A program that links ilp_flight_heap has no other malloc. Until seal_heap() the region `early` serves all requests:
// the C library's start-up, stdio and threads. A HeapGateScope opens the region that it names for its thread; one
// thread at a time may have a region open. After sealing, every request outside an open region is a trap: it is
// counted, reported on standard error and refused. Start-up is single-threaded.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fsw/base/heap_gate.hpp"

namespace ilp {

enum class HeapTrapMode : std::uint8_t {
  report,  ///< the request gets nullptr and the program continues
  strict   ///< the program aborts: for the test that a flight allocates nothing
};

/// Ends the service of the region `early`. Call it once, at the end of start-up.
void seal_heap(HeapTrapMode mode);
/// Number of requests that were refused since sealing.
[[nodiscard]] std::uint64_t heap_trap_count();

struct HeapRegionReport {
  const char* name = "";
  std::size_t bytes = 0;       ///< size of the region
  std::size_t in_use = 0;      ///< bytes in use at present
  std::size_t peak = 0;        ///< largest value of `in_use`
  std::size_t high_water = 0;  ///< size of the smallest region that would have sufficed
  std::uint64_t requests = 0;
  std::uint64_t failed = 0;  ///< requests that found the region exhausted
};
/// Returns size and use of a region.
[[nodiscard]] HeapRegionReport heap_region_report(HeapRegion region);

/// For tests: request number `nth` (from 1) after each later opening of a region fails as if the region were exhausted.
/// 0 switches the fault off.
void set_heap_fault(std::uint64_t nth);

}  // namespace ilp
