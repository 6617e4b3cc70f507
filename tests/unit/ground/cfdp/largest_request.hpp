#pragma once

#include <cstddef>

namespace ilp::test {

/// The largest single request of the heap since it was set to 0.
extern std::size_t largest_request;

}  // namespace ilp::test
