// Runs the flight on a static stack of fixed size (measured_stack.hpp) and measures its use.
#pragma once

#include <cstddef>

namespace ilp {

/// Calls body(context) on the flight's stack and waits for its end; `result` becomes its return value. Call it once,
/// before the heap is sealed. Returns 0 if the body was called, else an errno.
int call_on_flight_stack(int (*body)(void*), void* context, int& result);

/// Deepest use of the stack until now, bytes. May be called from any thread.
[[nodiscard]] std::size_t flight_stack_peak();
/// Size of the stack.
[[nodiscard]] std::size_t flight_stack_bytes();

}  // namespace ilp
