#include "bsp/linux/memory_report.hpp"

#include <cstdio>

#include "bsp/flight/flight_software.hpp"
#include "bsp/flight/packet_links.hpp"
#include "bsp/linux/board.hpp"
#include "bsp/linux/chosen_store.hpp"
#include "bsp/linux/flight_stack.hpp"
#include "bsp/linux/flight_worker.hpp"
#include "bsp/linux/image_sources.hpp"
#include "bsp/memory/flight_heap.hpp"
#include "cfg/version.hpp"
#include "hal/link/outbox/outbox_link.hpp"

namespace ilp {

void print_memory_map() {
  std::size_t total = 0;
  std::printf("Static memory of the flight, version %s, profile %s\n", software_version, limits::profile);
  const auto row = [&total](std::size_t bytes, const char* name) {
    total += bytes;
    std::printf("%12zu  %s\n", bytes, name);
  };
  for (const MemoryRegion& region : memory_map()) row(region.bytes, region.name);
  // Nothing without PostgreSQL.
  if (const std::size_t server = sizeof(ChosenStore) - sizeof(FlightStore); server > Arena::alignment) {
    row(server, "store on a server");
    row(heap_region_report(HeapRegion::postgres).bytes, "PostgreSQL's library");
  }
  row(sizeof(FlightStore) + sizeof(ImageSources::Chosen) + sizeof(OutboxLink) + sizeof(PacketLinks),
      "hardware abstraction layer");
  row(heap_region_report(HeapRegion::jpeg).bytes, "JPEG arena");
  row(heap_region_report(HeapRegion::early).bytes, "start-up heap");
  row(limits::flight_stack_bytes, "flight stack");
  row(worker_region_bytes, "worker stack");
  row(static_bytes() - total, "libraries, tables and the rest");
  std::printf("%12zu  total (%.1f MiB), all that is writable in the binary\n", total,
              static_cast<double>(total) / 1048576.0);
  std::printf("%12zu  code and constants\n", constant_bytes());
}

void print_memory_use(const FlightStore& store) {
  for (const HeapRegion region : {HeapRegion::early, HeapRegion::openjpeg, HeapRegion::postgres, HeapRegion::jpeg}) {
    const HeapRegionReport report = heap_region_report(region);
    std::printf("%s: peak %zu of %zu bytes, %llu requests, %llu failed\n", report.name, report.peak, report.bytes,
                static_cast<unsigned long long>(report.requests), static_cast<unsigned long long>(report.failed));
  }
  const ArenaStats& memory = store.memory_use();
  std::printf("store: peak %zu of %zu bytes, %llu requests, %llu failed\n", memory.peak, memory.capacity,
              static_cast<unsigned long long>(memory.requests), static_cast<unsigned long long>(memory.failed));
  std::printf("stack: peak %zu of %zu bytes\n", flight_stack_peak(), flight_stack_bytes());
  std::printf("heap requests after sealing: %llu\n", static_cast<unsigned long long>(heap_trap_count()));
}

}  // namespace ilp
