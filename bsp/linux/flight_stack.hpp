// The flight's stack: static, of a declared size, measured, with a protected page at its end.
#pragma once

#include <cstddef>

namespace ilp {

/// Calls body(context) on the flight's stack and waits for it; `result` is its return value. Call it once, before the
/// heap is sealed. Returns an errno, 0 when the body was called.
int call_on_flight_stack(int (*body)(void*), void* context, int& result);

/// Deepest use so far, bytes. It may be called from anywhere.
[[nodiscard]] std::size_t flight_stack_peak();
[[nodiscard]] std::size_t flight_stack_bytes();

}  // namespace ilp
