// Reads files with secrets, such as keys and tokens, and refuses those that other users can read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"

namespace ilp {

/// Fills `bytes`, or reads to the end of the file; `size` is the number of bytes read. Returns `not_found` if there is
/// no file, `io_error` (first value: errno; EINVAL if it is no regular file) if it cannot be read, and
/// `file_not_private` if its permissions allow any access to others than the owner.
Status read_private_file(const char* path, std::span<std::uint8_t> bytes, std::size_t& size);

}  // namespace ilp
