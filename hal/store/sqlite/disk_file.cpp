#include "hal/store/sqlite/disk_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

namespace ilp {
namespace {

bool ends_at(int file, std::int64_t at) {
  struct stat state {};
  return ::fstat(file, &state) == 0 && state.st_size <= static_cast<off_t>(at);
}

}  // namespace

Status open_disk_file(const char* path, int how, int& file) {
  int reason = 0;
  for (int failed = 0; failed < disk_attempts; ++failed) {
    file = ::open(path, how | O_CLOEXEC, 0644);
    reason = errno;
    if (file >= 0 || reason == ENOENT || reason == ENOTDIR) return {};
  }
  return {StatusCode::io_error, reason};
}

Status read_at(int file, std::span<std::uint8_t> to, std::int64_t at, std::size_t& got) {
  got = 0;
  int reason = EIO;
  for (int failed = 0; failed < disk_attempts;) {
    if (got == to.size()) return {};
    const std::int64_t from = at + static_cast<std::int64_t>(got);
    const ssize_t bytes = ::pread(file, to.data() + got, to.size() - got, static_cast<off_t>(from));
    if (bytes > 0) {
      got += static_cast<std::size_t>(bytes);
    } else if (bytes == 0 && ends_at(file, from)) {
      return {};
    } else {
      reason = bytes == 0 ? EIO : errno;
      ++failed;
    }
  }
  return {StatusCode::io_error, reason};
}

Status write_at(int file, std::span<const std::uint8_t> from, std::int64_t at) {
  std::size_t done = 0;
  int reason = EIO;
  for (int failed = 0; failed < disk_attempts;) {
    if (done == from.size()) return {};
    const auto to = static_cast<off_t>(at + static_cast<std::int64_t>(done));
    const ssize_t bytes = ::pwrite(file, from.data() + done, from.size() - done, to);
    if (bytes > 0) {
      done += static_cast<std::size_t>(bytes);
    } else {
      reason = bytes == 0 ? EIO : errno;
      ++failed;
    }
  }
  return {StatusCode::io_error, reason};
}

Result<bool> look_for(const char* path) {
  struct stat state {};
  int reason = 0;
  for (int failed = 0; failed < disk_attempts; ++failed) {
    if (::stat(path, &state) == 0) return true;
    reason = errno;
    if (reason == ENOENT || reason == ENOTDIR) return false;
  }
  return Status{StatusCode::io_error, reason};
}

}  // namespace ilp
