// The worker of a flight on this board: a thread with a static stack, or none (docs/worker.md).
#pragma once

#include "bsp/linux/options.hpp"
#include "hal/worker/thread_worker.hpp"

namespace ilp {

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
