// The flight's end of the connection to a compute device. The device's driver runs in a program of its own
// (bsp/vulkan), because a driver allocates memory and the flight does not. Flight and program share memory
// (compute_memory.hpp) and a Unix socket. A byte on the socket announces a job or a result; the socket's end shows that
// the program has ended. Only pause() waits.
#pragma once

#include <array>

#include "fsw/base/time.hpp"
#include "hal/compute/shared/compute_memory.hpp"

namespace ilp {

struct SharedComputeOptions {
  const char* path = nullptr;       ///< path of the program's socket
  TimeNs limit_ns = 10 * ns_per_s;  ///< longest time for one job; after it the device is `late`
};

class SharedCompute final : public ComputeDevice {
 public:
  explicit SharedCompute(const ComputeForms& forms) : forms_(forms) {}
  ~SharedCompute() { leave(); }

  /// Connects to the program, which must listen, and passes it the memory. Returns `unreachable` if that fails; begin()
  /// and ask() then return the same.
  ComputeFault open(const SharedComputeOptions& options);

  /// Sets SharedComputeOptions::limit_ns for jobs that begin later.
  void limit(TimeNs limit_ns) { options_.limit_ns = limit_ns; }

  ComputeFault begin(const ComputeJob& job) override;
  ComputeFault ask(ComputeKind kind, bool& done) override;
  void pause() override;
  void leave() override;

 private:
  struct Place {
    std::uint32_t number = 0;  ///< number of the latest job of this kind, from 1
    TimeNs deadline_ns = 0;    ///< when the device is late, by the board's monotonic clock
    std::span<std::byte> output;
  };

  const ComputeForms& forms_;
  SharedComputeOptions options_;
  ComputeMemory memory_;
  int socket_ = -1;
  ComputeFault closed_ = ComputeFault::unreachable;  ///< what begin() and ask() return without a socket
  std::array<Place, compute_kinds> places_{};
};

}  // namespace ilp
