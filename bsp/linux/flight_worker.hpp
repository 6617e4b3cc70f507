// Starts the worker of a flight: a thread with a static stack, or none (docs/worker.md).
#pragma once

#include <cstddef>

#include "bsp/linux/options.hpp"
#include "cfg/limits.hpp"
#include "hal/posix/measured_stack.hpp"
#include "hal/worker/thread_worker.hpp"

namespace ilp {

/// Size of the thread's stack with the protected page at its end.
inline constexpr std::size_t worker_region_bytes = limits::worker_stack_bytes + stack_page_bytes;

class FlightWorker {
 public:
  /// Starts the thread if the options request one. In virtual time the flight waits for the thread's jobs. Call it
  /// before the heap is sealed. Returns 0, or an errno if the thread cannot be started; jobs then run in the flight's
  /// steps.
  int begin(const Options& options);
  /// The worker for FlightDevices; null: there is no thread.
  Worker* worker() { return has_thread_ ? &thread_ : nullptr; }
  /// Waits for the job, ends the thread and prints its counts. Does nothing if the job is stuck.
  void end();

 private:
  ThreadWorker thread_;
  bool has_thread_ = false;
};

}  // namespace ilp
