// The flight's end of a compute device whose driver runs in a program of its own (bsp/vulkan), because a driver
// allocates and the flight does not. They share memory (compute_memory.hpp) and a Unix socket: a byte on it says that
// there is a job or a result, and its end says that the program has ended. No call blocks after open().
#pragma once

#include <array>

#include "fsw/base/time.hpp"
#include "hal/compute/shared/compute_memory.hpp"

namespace ilp {

struct SharedComputeOptions {
  const char* path = nullptr;       ///< of the program's socket
  TimeNs limit_ns = 10 * ns_per_s;  ///< for one job; longer is late
};

class SharedCompute final : public ComputeDevice {
 public:
  explicit SharedCompute(const ComputeForms& forms) : forms_(forms) {}
  ~SharedCompute() { leave(); }

  /// Connects to the program, which must listen, and gives it the memory. After a fault every job has that fault.
  ComputeFault open(const SharedComputeOptions& options);

  /// Of the jobs from now on.
  void limit(TimeNs limit_ns) { options_.limit_ns = limit_ns; }

  ComputeFault begin(const ComputeJob& job) override;
  ComputeFault ask(ComputeKind kind, bool& done) override;
  void pause() override;
  void leave() override;

 private:
  struct Place {
    std::uint32_t number = 0;
    TimeNs deadline_ns = 0;  ///< of the board's monotonic clock
    std::span<std::byte> output;
  };

  const ComputeForms& forms_;
  SharedComputeOptions options_;
  ComputeMemory memory_;
  int socket_ = -1;
  ComputeFault closed_ = ComputeFault::unreachable;  ///< why there is no socket
  std::array<Place, compute_kinds> places_{};
};

}  // namespace ilp
