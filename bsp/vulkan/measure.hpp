// Measures the time of a wide search on the device and on the processor, and compares the bytes of their results.
#pragma once

#include "bsp/vulkan/wide_search_job.hpp"

namespace ilp {

/// Runs a complete search on images of 160 x 120 px on both and prints the times. Returns false if a byte differs.
bool measure_wide_search(WideSearchJob& search);

}  // namespace ilp
