#include "hal/posix/file.hpp"

#include <unistd.h>

#include <cerrno>

namespace ilp {
namespace {
// A signal may interrupt a call; more of them in a row than this is a fault.
constexpr int max_interruptions = 100;
}  // namespace

Status write_all(int file, std::span<const std::uint8_t> bytes) {
  int interruptions = 0;
  while (!bytes.empty()) {
    const ssize_t n = ::write(file, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR && ++interruptions < max_interruptions) continue;
    if (n <= 0) return {StatusCode::io_error, errno};
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return {};
}

Status read_some(int file, std::span<std::uint8_t> bytes, std::size_t& size) {
  size = 0;
  int interruptions = 0;
  while (size < bytes.size()) {
    const ssize_t n = ::read(file, bytes.data() + size, bytes.size() - size);
    if (n < 0 && errno == EINTR && ++interruptions < max_interruptions) continue;
    if (n < 0) return {StatusCode::io_error, errno};
    if (n == 0) break;
    size += static_cast<std::size_t>(n);
  }
  return {};
}

}  // namespace ilp
