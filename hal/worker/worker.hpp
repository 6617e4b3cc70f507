// Work that cannot be cut into steps, beside the executive (docs/worker.md). Nobody waits for it: a job is handed over
// in one minor frame, and asked for in later ones.
#pragma once

#include <cstdint>

#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"

namespace ilp {

/// A pure function of its memory: whoever runs it, and whenever, leaves the same bytes there. From submit() until it is
/// told done, the memory belongs to the worker alone.
struct WorkerJob {
  void (*run)(void* memory) = nullptr;
  void* memory = nullptr;
};

/// A job with more processor time than this has lost its way: the longest one takes less than a second at 1000 MIPS.
inline constexpr TimeNs worker_limit_ns = 60 * ns_per_s;

enum class WorkerProgress : std::uint8_t {
  idle,     ///< there is no job
  working,  ///< ask in the next minor frame
  done,     ///< told once: the memory is the caller's again, and the worker takes another job
  stuck     ///< the limit is exceeded: the job's memory stays with the worker until it ends after all
};

class Worker {
 public:
  Worker() = default;
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// There is one job at a time, until it was told done: else `not_ready`.
  virtual Status submit(const WorkerJob& job) = 0;
  /// It never waits, unless mission time stands still.
  virtual WorkerProgress ask() = 0;
  /// Waits until the job has ended or is stuck. Only at the end of the flight, and where mission time stands still.
  virtual void finish() = 0;

 protected:
  ~Worker() = default;
};

}  // namespace ilp
