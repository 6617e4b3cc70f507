// Reads and writes complete spans on a POSIX file descriptor, with a bounded number of retries after signals. The
// functions return `io_error` (first value: errno) on failure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"

namespace ilp {

Status write_all(int file, std::span<const std::uint8_t> bytes);
/// Fills `bytes`, or reads to the end of the file; `size` is the number of bytes read.
Status read_some(int file, std::span<std::uint8_t> bytes, std::size_t& size);

/// Calls read(2) once; `size` is the number of bytes read, 0 at the end of the file.
Status read_once(int file, std::span<std::uint8_t> bytes, std::size_t& size);
/// Synchronises the folder of the file, so that the file's name survives a power cut.
Status synchronise_folder_of(const char* path);
/// Waits until a read would not block, at most `milliseconds`. Returns true if bytes have arrived, the file has ended
/// or the descriptor has failed.
[[nodiscard]] bool wait_readable(int file, int milliseconds);

}  // namespace ilp
