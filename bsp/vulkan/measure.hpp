// Times of the jobs of a wide search on the device and on the processor, and whether their bytes agree.
#pragma once

#include "bsp/vulkan/wide_search_job.hpp"

namespace ilp {

/// Does a whole search of images of 160 x 120 px on both and prints the result. Returns false where a byte differs.
bool measure_wide_search(WideSearchJob& search);

}  // namespace ilp
