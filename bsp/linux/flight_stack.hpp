// The stack that the flight runs on: static, of a declared size, measured, and with a page at its end that nobody may
// touch.
#pragma once

#include <cstddef>

namespace ilp {

/// Calls body(context) on the flight's stack and waits for it; `result` is what it returned. To be called once, before
/// the heap is sealed. Returns an errno, 0 when the body was called.
int call_on_flight_stack(int (*body)(void*), void* context, int& result);

/// Deepest use so far, bytes; from anywhere.
[[nodiscard]] std::size_t flight_stack_peak();
[[nodiscard]] std::size_t flight_stack_bytes();

}  // namespace ilp
