// Accesses a video device of Linux through system calls.
#pragma once

#include "hal/camera/v4l2/video_device.hpp"

namespace ilp {

class LinuxVideoDevice final : public VideoDevice {
 public:
  LinuxVideoDevice() = default;
  ~LinuxVideoDevice();

  [[nodiscard]] int open(const char* path) override;
  void close() override;
  [[nodiscard]] int control(unsigned long request, void* argument) override;
  [[nodiscard]] int map(std::size_t length, std::int64_t offset, std::span<const std::uint8_t>& bytes) override;
  void unmap(std::span<const std::uint8_t> bytes) override;
  [[nodiscard]] int wait(int timeout_ms, bool& readable) override;

 private:
  int file_ = -1;
};

}  // namespace ilp
