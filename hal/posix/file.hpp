// Reads and writes whole spans on a POSIX file descriptor, with bounded retries.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"

namespace ilp {

Status write_all(int file, std::span<const std::uint8_t> bytes);
/// Fills `bytes` as far as the file reaches; `size` is the number of bytes read. End of file is ok with a smaller size.
Status read_some(int file, std::span<std::uint8_t> bytes, std::size_t& size);

/// One read: `size` bytes have arrived, 0 at the end of the file.
Status read_once(int file, std::span<std::uint8_t> bytes, std::size_t& size);
/// Makes the file's name in its folder survive a power cut.
Status synchronise_folder_of(const char* path);
/// Waits until a read would not wait: true for bytes that have arrived, for the end of the file and for a fault.
[[nodiscard]] bool wait_readable(int file, int milliseconds);

}  // namespace ilp
