#include "hal/posix/file.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>

#include "cfg/limits.hpp"
#include "fsw/base/text.hpp"

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
    if (n <= 0) return {StatusCode::io_error, n < 0 ? errno : ENOSPC};
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

Status synchronise_folder_of(const char* path) {
  FixedText<limits::max_path_bytes> folder;
  const char* const name = base_name(path);
  for (const char* c = path; c != name; ++c) folder.add(*c);
  const int file = ::open(name == path ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) return {StatusCode::io_error, errno};
  const Status status = ::fsync(file) == 0 ? Status{} : Status{StatusCode::io_error, errno};
  ::close(file);
  return status;
}

bool wait_readable(int file, int milliseconds) {
  pollfd wanted{file, POLLIN, 0};
  return ::poll(&wanted, 1, milliseconds) > 0;
}

}  // namespace ilp
