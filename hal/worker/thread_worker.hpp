// A worker that runs jobs in a thread with a lower priority than the executive, on a stack of its own.
#pragma once

#include <pthread.h>
#include <semaphore.h>

#include <atomic>
#include <cstddef>
#include <span>

#include "hal/worker/worker.hpp"

namespace ilp {

struct WorkerStats {
  std::uint64_t jobs = 0;
  TimeNs busy_ns = 0;     ///< processor time of all jobs
  TimeNs longest_ns = 0;  ///< processor time of the longest job
};

/// The thread has the ordinary scheduling class and the nice value 10. An executive of the real-time class preempts the
/// thread. An executive of the ordinary class gets about ten times the thread's share of a processor that both need.
class ThreadWorker final : public Worker {
 public:
  explicit ThreadWorker(TimeNs limit_ns = worker_limit_ns) : limit_ns_(limit_ns) {}

  /// Starts the thread. `stack` is static memory that begins at a page and has whole pages (measured_stack.hpp). Call
  /// start() once, before the heap is sealed. Returns 0 when the thread runs, else an errno.
  int start(std::span<std::byte> stack);
  /// For flights in virtual time: ask() waits for the job, so that a job ends in the same minor frame in every run.
  void wait_for_answers() { patient_ = true; }
  /// Waits for the job and ends the thread. Returns false if the job is stuck; the thread then goes on.
  bool stop();

  /// Returns `not_ready` also before start() and after stop().
  Status submit(const WorkerJob& job) override;
  WorkerProgress ask() override;
  void finish() override;

  /// Counts of finished jobs. Read them only while no job runs.
  [[nodiscard]] const WorkerStats& stats() const { return stats_; }

 private:
  enum class State : std::uint8_t { idle, working, done };

  static void* enter(void* worker);
  void work();
  /// Processor time that the thread has used, ns.
  [[nodiscard]] TimeNs used() const;
  [[nodiscard]] bool stuck() const { return used() - begun_ns_ > limit_ns_; }

  TimeNs limit_ns_;
  bool running_ = false;
  bool patient_ = false;
  pthread_t thread_{};
  clockid_t processor_clock_{};
  sem_t wake_{};   ///< wakes the thread for a job or for its end
  sem_t ended_{};  ///< posted when a job has ended
  std::atomic<State> state_{State::idle};
  std::atomic<bool> leaving_{false};
  TimeNs begun_ns_ = 0;  ///< the thread's processor time before the job
  // These belong to the thread while `state_` is `working`.
  WorkerJob job_;
  WorkerStats stats_;
};

}  // namespace ilp
