#include "hal/posix/measured_stack.hpp"

#include <sys/mman.h>

#include <cstring>

namespace ilp {
namespace {

constexpr std::byte untouched{0xA5};

}  // namespace

void prepare_stack(std::span<std::byte> memory) {
  std::memset(memory.data(), std::to_integer<int>(untouched), memory.size());
  static_cast<void>(mprotect(memory.data(), stack_page_bytes, PROT_NONE));
}

std::size_t stack_peak(std::span<const std::byte> memory) {
  std::size_t untouched_bytes = stack_page_bytes;
  while (untouched_bytes < memory.size() && memory[untouched_bytes] == untouched) ++untouched_bytes;
  return memory.size() - untouched_bytes;
}

}  // namespace ilp
