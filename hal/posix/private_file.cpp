#include "hal/posix/private_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "hal/posix/file.hpp"

namespace ilp {
namespace {

Status check_permissions(int file) {
  struct stat facts {};
  if (::fstat(file, &facts) != 0) return {StatusCode::io_error, errno};
  if (!S_ISREG(facts.st_mode)) return {StatusCode::io_error, EINVAL};
  return (facts.st_mode & (S_IRWXG | S_IRWXO)) == 0 ? Status{} : Status{StatusCode::file_not_private};
}

}  // namespace

Status read_private_file(const char* path, std::span<std::uint8_t> bytes, std::size_t& size) {
  size = 0;
  // A pipe without a writer must not hold up the start.
  const int file = ::open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) return errno == ENOENT ? Status{StatusCode::not_found} : Status{StatusCode::io_error, errno};
  Status status = check_permissions(file);
  if (status.ok()) status = read_some(file, bytes, size);
  ::close(file);
  return status;
}

}  // namespace ilp
