// The worker of a flight on this board: a thread with a static stack, or none (docs/worker.md).
#pragma once

#include <cstddef>

#include "bsp/linux/options.hpp"
#include "cfg/limits.hpp"
#include "hal/posix/measured_stack.hpp"
#include "hal/worker/thread_worker.hpp"

namespace ilp {

/// The stack, and the page that guards its end.
inline constexpr std::size_t worker_region_bytes = limits::worker_stack_bytes + stack_page_bytes;

class FlightWorker {
 public:
  /// Starts the thread if the options want one. In virtual time the flight waits for its jobs. Call it before the heap
  /// is sealed. Returns an errno; without the thread the flight does the jobs in its steps.
  int begin(const Options& options);
  /// Null: there is no thread.
  Worker* worker() { return has_thread_ ? &thread_ : nullptr; }
  /// Waits for the job, unless it is stuck, and prints what the thread has done.
  void end();

 private:
  ThreadWorker thread_;
  bool has_thread_ = false;
};

}  // namespace ilp
