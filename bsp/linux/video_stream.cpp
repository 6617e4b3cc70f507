#include "bsp/linux/video_stream.hpp"

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

Status open_video_stream(const char* file, bool real_time, Y4mCamera& camera) {
  const bool standard_input = std::strcmp(file, "-") == 0;
  const int descriptor = standard_input ? STDIN_FILENO : ::open(file, O_RDONLY | O_CLOEXEC);
  struct stat about = {};
  if (descriptor < 0 || fstat(descriptor, &about) != 0) return {StatusCode::io_error, errno};
  if (S_ISFIFO(about.st_mode)) static_cast<void>(fcntl(descriptor, F_SETPIPE_SZ, pipe_bytes));
  return camera.open(descriptor, {.live = real_time && !S_ISREG(about.st_mode)});
}

}  // namespace ilp
