// Reading and writing of an open file that a fault which passes does not disturb.
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/result.hpp"

namespace ilp {

/// A call of the system that fails is tried this often.
inline constexpr int disk_attempts = 3;

/// `file` is -1 if there is none of this name. `how` are flags of open(2). `io_error` (a = errno): it could not be
/// opened, and may be there.
Status open_disk_file(const char* path, int how, int& file);
/// `got` is less than the size of `to` only at the end of the file. `io_error` (a = errno): it could not be read, which
/// says nothing about its content.
Status read_at(int file, std::span<std::uint8_t> to, std::int64_t at, std::size_t& got);
/// `io_error` (a = errno): any part of it may have been written.
Status write_at(int file, std::span<const std::uint8_t> from, std::int64_t at);
/// Whether there is a file of this name. `io_error` (a = errno) when that cannot be found out.
Result<bool> look_for(const char* path);

}  // namespace ilp
