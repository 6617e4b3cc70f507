// Scratch memory of Downlink in one step: a product that is read, and the file that is made for the delivery queue.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/shared/step_memory.hpp"

namespace ilp {

struct DownlinkBuffers {
  std::array<std::uint8_t, limits::max_product_bytes> product;
  std::array<std::uint8_t, limits::max_transfer_bytes> file;
};

}  // namespace ilp
