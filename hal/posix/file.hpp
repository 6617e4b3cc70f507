// Reading and writing whole spans on a POSIX file descriptor, with bounded retries.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"

namespace ilp {

Status write_all(int file, std::span<const std::uint8_t> bytes);
/// Fills as much of `bytes` as the file has; `size` says how much. End of file is ok with a smaller size.
Status read_some(int file, std::span<std::uint8_t> bytes, std::size_t& size);

}  // namespace ilp
