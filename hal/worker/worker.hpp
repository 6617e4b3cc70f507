// Interface for jobs that cannot be cut into steps and run beside the executive (docs/worker.md). A component submits a
// job in one minor frame and asks for its progress in later ones.
#pragma once

#include <cstdint>

#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"

namespace ilp {

/// `run` is a pure function of `memory`: it leaves the same bytes there in any thread and at any time. The memory
/// belongs to the worker from submit() until ask() returns `done`.
struct WorkerJob {
  void (*run)(void* memory) = nullptr;
  void* memory = nullptr;
};

/// A job that uses more processor time than this is stuck. The longest job takes less than a second at 1000 MIPS.
inline constexpr TimeNs worker_limit_ns = 60 * ns_per_s;

enum class WorkerProgress : std::uint8_t {
  idle,     ///< there is no job
  working,  ///< ask again in the next minor frame
  done,     ///< returned once: the memory is the caller's again, and the worker accepts another job
  stuck     ///< the limit is exceeded: the memory stays with the worker, and `done` may still follow
};

class Worker {
 public:
  Worker() = default;
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// Begins a job. Returns `not_ready` until ask() has returned `done` for the job before.
  virtual Status submit(const WorkerJob& job) = 0;
  /// Returns the progress of the job. Waits for the job only in flights in virtual time.
  virtual WorkerProgress ask() = 0;
  /// Waits until the job has ended or is stuck. Called only at the end of a flight and in flights in virtual time.
  virtual void finish() = 0;

 protected:
  ~Worker() = default;
};

}  // namespace ilp
