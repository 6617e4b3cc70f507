#include "hal/camera/v4l2/linux_video_device.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>

namespace ilp {
namespace {

constexpr int interruptions = 4;  // signals that one call survives

}  // namespace

LinuxVideoDevice::~LinuxVideoDevice() {
  LinuxVideoDevice::close();
}

int LinuxVideoDevice::open(const char* path) {
  close();
  file_ = ::open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC);
  return file_ < 0 ? errno : 0;
}

void LinuxVideoDevice::close() {
  if (file_ >= 0) ::close(file_);
  file_ = -1;
}

int LinuxVideoDevice::control(unsigned long request, void* argument) {
  int error = EINTR;
  for (int i = 0; i < interruptions && error == EINTR; ++i) {
    error = ::ioctl(file_, request, argument) < 0 ? errno : 0;
  }
  return error;
}

int LinuxVideoDevice::map(std::size_t length, std::int64_t offset, std::span<const std::uint8_t>& bytes) {
  // Some drivers refuse a mapping without write access.
  void* const memory = ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, file_, static_cast<off_t>(offset));
  if (memory == MAP_FAILED) return errno;
  bytes = {static_cast<const std::uint8_t*>(memory), length};
  return 0;
}

void LinuxVideoDevice::unmap(std::span<const std::uint8_t> bytes) {
  ::munmap(const_cast<std::uint8_t*>(bytes.data()), bytes.size());
}

int LinuxVideoDevice::wait(int timeout_ms, bool& readable) {
  pollfd entry{file_, POLLIN, 0};
  const int count = ::poll(&entry, 1, timeout_ms);
  // The next VIDIOC_DQBUF reports a pending error.
  readable = count > 0;
  return count < 0 && errno != EINTR ? errno : 0;
}

}  // namespace ilp
