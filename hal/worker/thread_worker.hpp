// Runs jobs in a thread below the priority of the executive, on a stack of its own.
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
  TimeNs busy_ns = 0;  ///< processor time
  TimeNs longest_ns = 0;
};

/// The thread has the ordinary scheduling class and the nice value 10. An executive of the real-time class goes before
/// it; an executive of the ordinary class gets about ten times its share where both want the same processor.
class ThreadWorker final : public Worker {
 public:
  explicit ThreadWorker(TimeNs limit_ns = worker_limit_ns) : limit_ns_(limit_ns) {}

  /// `stack` is static, begins at a page and has whole pages (measured_stack.hpp). Call it once, before the heap is
  /// sealed. Returns an errno, 0 when the thread runs.
  int start(std::span<std::byte> stack);
  /// Mission time stands still: ask() waits for the job, so that no minor frame passes meanwhile.
  void wait_for_answers() { patient_ = true; }
  /// Waits for the job and ends the thread. Returns false, and leaves the thread, if the job is stuck.
  bool stop();

  /// `not_ready` also before start() and after stop().
  Status submit(const WorkerJob& job) override;
  WorkerProgress ask() override;
  void finish() override;

  /// Of the jobs that were told done.
  [[nodiscard]] const WorkerStats& stats() const { return stats_; }

 private:
  enum class State : std::uint8_t { idle, working, done };

  static void* enter(void* worker);
  void work();
  /// Processor time of the thread so far.
  [[nodiscard]] TimeNs used() const;
  [[nodiscard]] bool stuck() const { return used() - begun_ns_ > limit_ns_; }

  TimeNs limit_ns_;
  bool running_ = false;
  bool patient_ = false;
  pthread_t thread_{};
  clockid_t processor_clock_{};
  sem_t wake_{};   ///< of the thread: a job, or the end
  sem_t ended_{};  ///< a job has ended
  std::atomic<State> state_{State::idle};
  std::atomic<bool> leaving_{false};
  TimeNs begun_ns_ = 0;  ///< the thread's processor time before the job
  // The thread's from submit() to the end of the job, which `state_` hands over and back.
  WorkerJob job_;
  WorkerStats stats_;
};

}  // namespace ilp
