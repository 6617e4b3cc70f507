// Files of secrets: keys and tokens.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"

namespace ilp {

/// Fills `bytes` as far as the file reaches; `size` is the number of bytes read. `not_found`; `io_error` (a = errno,
/// EINVAL for what is no plain file); `file_not_private` if its permissions let others than the owner use it.
Status read_private_file(const char* path, std::span<std::uint8_t> bytes, std::size_t& size);

}  // namespace ilp
