#include "bsp/flight/key_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>

#include "hal/posix/file.hpp"

namespace ilp {

Status read_key_file(const char* path, Authenticator& authenticator) {
  std::array<std::uint8_t, 4096> text{};
  const int file = ::open(path, O_RDONLY | O_CLOEXEC);
  if (file < 0) return errno == ENOENT ? Status{StatusCode::not_found} : Status{StatusCode::io_error, errno};
  std::size_t size = 0;
  const Status status = read_some(file, text, size);
  ::close(file);
  ILP_TRY(status);
  if (size == text.size()) {
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(size), static_cast<std::int64_t>(text.size()) - 1};
  }
  return authenticator.add_keys({reinterpret_cast<const char*>(text.data()), size});
}

}  // namespace ilp
