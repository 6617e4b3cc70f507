// ilp-compute-vulkan under Mesa's lavapipe, for as long as a test needs it.
#pragma once

#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>

namespace ilp::test {

class VulkanProgram {
 public:
  VulkanProgram() : socket_("/tmp/ilp-vulkan-test-" + std::to_string(getpid())) {
    std::filesystem::remove(socket_);
    setenv("VK_DRIVER_FILES", ILP_LAVAPIPE, 1);
    setenv("VK_ICD_FILENAMES", ILP_LAVAPIPE, 1);
    const char* const arguments[] = {ILP_COMPUTE_VULKAN, "--socket", socket_.c_str(), "--device", "llvmpipe", nullptr};
    if (posix_spawn(&id_, arguments[0], nullptr, nullptr, const_cast<char* const*>(arguments), environ) != 0) id_ = -1;
    for (int i = 0; i < 600 && !std::filesystem::exists(socket_); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  }
  ~VulkanProgram() {
    send(SIGKILL);
    waitpid(id_, nullptr, 0);
    std::filesystem::remove(socket_);
  }
  VulkanProgram(const VulkanProgram&) = delete;
  VulkanProgram& operator=(const VulkanProgram&) = delete;

  void send(int signal) const {
    if (id_ > 0) kill(id_, signal);
  }
  [[nodiscard]] const char* socket() const { return socket_.c_str(); }

 private:
  std::string socket_;
  pid_t id_ = -1;
};

}  // namespace ilp::test
