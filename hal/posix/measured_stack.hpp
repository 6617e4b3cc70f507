// Prepares a thread's stack in static memory: a protected page ends an overflow, and the deepest use is measured.
#pragma once

#include <cstddef>
#include <span>

namespace ilp {

inline constexpr std::size_t stack_page_bytes = 4096;

/// Fills `memory` with a pattern and protects its first page. An overflow of the stack then ends the program before it
/// damages other data. `memory` begins at a page and has a whole number of pages. Call it before the thread begins.
void prepare_stack(std::span<std::byte> memory);
/// The part of `memory` that the thread may use.
[[nodiscard]] inline std::span<std::byte> usable_stack(std::span<std::byte> memory) {
  return memory.subspan(stack_page_bytes);
}
/// Deepest use of the stack until now, bytes: everything above the untouched pattern.
[[nodiscard]] std::size_t stack_peak(std::span<const std::byte> memory);

}  // namespace ilp
