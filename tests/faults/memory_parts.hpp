// The static memory of the flight by the regions of its memory map, each in two parts: what outlives a step, and
// pixels and workspaces.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace ilp::faults {

struct MemoryRegion {
  std::byte* begin = nullptr;
  std::size_t bytes = 0;
};

/// Everything of a component counts as state that is not named as a workspace in memory_parts.cpp.
struct MemoryPart {
  std::string name;
  bool state = true;
  std::vector<MemoryRegion> regions;
};

/// Their places do not change from one process to the next.
[[nodiscard]] std::vector<MemoryPart> memory_parts();

}  // namespace ilp::faults
