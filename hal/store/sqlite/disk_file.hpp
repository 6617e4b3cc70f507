// Reads and writes files, and repeats system calls that fail temporarily.
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/result.hpp"

namespace ilp {

/// Number of attempts of a system call that fails.
inline constexpr int disk_attempts = 3;

/// Opens a file; `how` are flags of open(2). `file` is -1 if there is no such file. Returns `io_error` (a = errno) if
/// it cannot be opened although it may exist.
Status open_disk_file(const char* path, int how, int& file);
/// Reads from the offset `at`. `got` is less than the size of `to` only at the end of the file. Returns `io_error` (a =
/// errno) if it cannot be read, which says nothing about the content.
Status read_at(int file, std::span<std::uint8_t> to, std::int64_t at, std::size_t& got);
/// Writes at the offset `at`. Returns `io_error` (a = errno) after a fault; any part of `from` may then have been
/// written.
Status write_at(int file, std::span<const std::uint8_t> from, std::int64_t at);
/// True if there is a file of this name. Returns `io_error` (a = errno) if this cannot be determined.
Result<bool> look_for(const char* path);

}  // namespace ilp
