// Sets controls of a video device at given times, with which vivid makes its own faults.
//
//   inject DEVICE [AT_S VALUE NAME]...
//
// Times count from the start. Controls before time 0 are set before it reports that it is ready. The device is opened
// again for each control, because it may be absent in between.

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "bsp/emulated-board/programs/readiness.hpp"
#include "bsp/emulated-board/programs/video_control.hpp"

namespace {

bool set(const char* path, const char* name, std::int32_t value) {
  const int device = open(path, O_RDWR | O_CLOEXEC);
  if (device < 0) return false;
  const bool good = board::set_control(device, name, value);
  const int error = errno;
  close(device);
  errno = error;
  return good;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || (argc - 2) % 3 != 0) {
    std::printf("usage: inject DEVICE [AT_S VALUE NAME]...\n");
    return 2;
  }
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const double begin = board::uptime_s();
  bool ready = false;
  for (int i = 2; i < argc; i += 3) {
    const double at = std::strtod(argv[i], nullptr);
    if (at >= 0) {
      if (!ready) board::say_ready();
      ready = true;
      board::sleep_until(begin + at);
    }
    const bool good = set(argv[1], argv[i + 2], static_cast<std::int32_t>(std::strtol(argv[i + 1], nullptr, 10)));
    std::printf("inject: %.3f %s = %s%s%s\n", board::uptime_s(), argv[i + 2], argv[i + 1], good ? "" : ": ",
                good ? "" : std::strerror(errno));
  }
  return 0;
}
