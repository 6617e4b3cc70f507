// Sets controls of a video device at given times: vivid's way to make its own faults.
//
//   inject DEVICE [AT_S VALUE NAME]...
//
// Times count from the start. Controls before time 0 are set before it says that it is ready. Each one is opened anew:
// a device may be gone in between.

#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

namespace {

constexpr int ready_descriptor = 3;

double uptime_s() {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

void sleep_until(double uptime) {
  timespec until{};
  until.tv_sec = static_cast<time_t>(uptime);
  until.tv_nsec = static_cast<long>((uptime - static_cast<double>(until.tv_sec)) * 1e9);
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

/// vivid's own controls have no numbers in any header; 0 when there is none of this name.
std::uint32_t find_control(int device, const char* name) {
  v4l2_queryctrl query{};
  query.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  while (ioctl(device, VIDIOC_QUERYCTRL, &query) == 0) {
    if (std::strcmp(reinterpret_cast<const char*>(query.name), name) == 0) return query.id;
    query.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  errno = ENOENT;
  return 0;
}

bool set(const char* path, const char* name, std::int32_t value) {
  const int device = open(path, O_RDWR | O_CLOEXEC);
  if (device < 0) return false;
  v4l2_control control{find_control(device, name), value};
  const bool good = control.id != 0 && ioctl(device, VIDIOC_S_CTRL, &control) == 0;
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
  const double begin = uptime_s();
  bool ready = false;
  for (int i = 2; i < argc; i += 3) {
    const double at = std::strtod(argv[i], nullptr);
    if (at >= 0) {
      if (!ready && write(ready_descriptor, "r", 1) == 1) close(ready_descriptor);
      ready = true;
      sleep_until(begin + at);
    }
    const bool good = set(argv[1], argv[i + 2], static_cast<std::int32_t>(std::strtol(argv[i + 1], nullptr, 10)));
    std::printf("inject: %.3f %s = %s%s%s\n", uptime_s(), argv[i + 2], argv[i + 1], good ? "" : ": ",
                good ? "" : std::strerror(errno));
  }
  return 0;
}
