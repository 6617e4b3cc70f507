#include "bsp/linux/stream_source.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace ilp {
namespace {

// The kernel's default lets an unprivileged process have this much. More of a frame then arrives in one slice.
constexpr int pipe_bytes = 1 << 20;

}  // namespace

Status StreamSource::read_header(const char* file) {
  if (opened_) return {};
  const bool standard_input = std::strcmp(file, "-") == 0;
  const int descriptor = standard_input ? STDIN_FILENO : ::open(file, O_RDONLY | O_CLOEXEC);
  struct stat about = {};
  if (descriptor < 0 || fstat(descriptor, &about) != 0) return {StatusCode::io_error, errno};
  if (S_ISFIFO(about.st_mode)) static_cast<void>(fcntl(descriptor, F_SETPIPE_SZ, pipe_bytes));
  ILP_TRY(camera_.open(descriptor, {.live = real_time_ && !S_ISREG(about.st_mode)}));
  opened_ = true;
  return {};
}

Status StreamSource::find_size(const char* value, std::int32_t& width, std::int32_t& height) {
  ILP_TRY(read_header(value));
  width = camera_.width();
  height = camera_.height();
  return {};
}

Status StreamSource::open(const char* value, std::int32_t width, std::int32_t height) {
  ILP_TRY(read_header(value));
  const bool fits = camera_.width() == width && camera_.height() == height;
  return fits ? Status{} : Status{StatusCode::image_size_changed, camera_.width(), camera_.height()};
}

}  // namespace ilp
