// The static stack of a thread: its deepest use is measured, and a protected page lies at its end.
#pragma once

#include <cstddef>
#include <span>

namespace ilp {

inline constexpr std::size_t stack_page_bytes = 4096;

/// `memory` begins at a page and has whole pages, of which the first one is protected: an overflow ends the program
/// there, before it damages other data. Call it before the thread begins.
void prepare_stack(std::span<std::byte> memory);
/// What the thread may use of it.
[[nodiscard]] inline std::span<std::byte> usable_stack(std::span<std::byte> memory) {
  return memory.subspan(stack_page_bytes);
}
/// Deepest use so far, bytes.
[[nodiscard]] std::size_t stack_peak(std::span<const std::byte> memory);

}  // namespace ilp
