#include "tests/unit/ground/cfdp/largest_request.hpp"

#include <algorithm>
#include <cstdlib>
#include <new>

namespace ilp::test {

std::size_t largest_request = 0;

}  // namespace ilp::test

void* operator new(std::size_t bytes) {
  ilp::test::largest_request = std::max(ilp::test::largest_request, bytes);
  void* const memory = std::malloc(bytes == 0 ? 1 : bytes);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
