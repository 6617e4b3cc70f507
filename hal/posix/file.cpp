#include "hal/posix/file.hpp"

#include <poll.h>
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

Status read_once(int file, std::span<std::uint8_t> bytes, std::size_t& size) {
  size = 0;
  for (int interruptions = 0; interruptions < max_interruptions; ++interruptions) {
    const ssize_t n = ::read(file, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return {StatusCode::io_error, errno};
    size = static_cast<std::size_t>(n);
    return {};
  }
  return {StatusCode::io_error, EINTR};
}

Status read_some(int file, std::span<std::uint8_t> bytes, std::size_t& size) {
  size = 0;
  while (size < bytes.size()) {
    std::size_t more = 0;
    ILP_TRY(read_once(file, bytes.subspan(size), more));
    if (more == 0) break;
    size += more;
  }
  return {};
}

bool wait_readable(int file, int milliseconds) {
  pollfd wanted{file, POLLIN, 0};
  return ::poll(&wanted, 1, milliseconds) > 0;
}

}  // namespace ilp
