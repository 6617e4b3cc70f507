#include "hal/worker/thread_worker.hpp"

#include <sched.h>
#include <sys/resource.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <ctime>

#include "hal/posix/measured_stack.hpp"

namespace ilp {
namespace {

constexpr int nice_value = 10;
/// Between two looks at the processor time of a job that is waited for.
constexpr TimeNs look_ns = 20 * ns_per_ms;

void wait(sem_t& semaphore) {
  while (sem_wait(&semaphore) != 0 && errno == EINTR) {  // bound: the signals that arrive
  }
}

void wait_a_while(sem_t& semaphore) {
  timespec until{};
  clock_gettime(CLOCK_REALTIME, &until);
  const TimeNs nanoseconds = until.tv_nsec + look_ns;
  until.tv_sec += nanoseconds / ns_per_s;
  until.tv_nsec = nanoseconds % ns_per_s;
  static_cast<void>(sem_timedwait(&semaphore, &until));
}

/// A refusal leaves the thread at the executive's priority; the results are the same.
void lower_priority() {
  const sched_param none{};
  static_cast<void>(sched_setscheduler(0, SCHED_OTHER, &none));
  // On Linux, 0 is the calling thread.
  static_cast<void>(setpriority(PRIO_PROCESS, 0, nice_value));
}

}  // namespace

int ThreadWorker::start(std::span<std::byte> stack) {
  prepare_stack(stack);
  pthread_attr_t attributes;
  int error = pthread_attr_init(&attributes);
  if (error != 0) return error;
  if (sem_init(&wake_, 0, 0) != 0 || sem_init(&ended_, 0, 0) != 0) return errno;
  const std::span<std::byte> usable = usable_stack(stack);
  error = pthread_attr_setstack(&attributes, usable.data(), usable.size());
  // Signals are for the flight's threads.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  if (error == 0) error = pthread_create(&thread_, &attributes, enter, this);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  pthread_attr_destroy(&attributes);
  if (error != 0) return error;
  running_ = true;
  return pthread_getcpuclockid(thread_, &processor_clock_);
}

void* ThreadWorker::enter(void* worker) {
  lower_priority();
  static_cast<ThreadWorker*>(worker)->work();
  return nullptr;
}

void ThreadWorker::work() {
  for (;;) {  // bound: the jobs; each turn waits for one, and stop() ends it
    wait(wake_);
    if (leaving_.load(std::memory_order_acquire)) return;
    if (state_.load(std::memory_order_acquire) != State::working) continue;
    const TimeNs begin = used();
    job_.run(job_.memory);
    const TimeNs used_ns = used() - begin;
    ++stats_.jobs;
    stats_.busy_ns += used_ns;
    stats_.longest_ns = std::max(stats_.longest_ns, used_ns);
    state_.store(State::done, std::memory_order_release);
    sem_post(&ended_);
  }
}

TimeNs ThreadWorker::used() const {
  timespec time{};
  clock_gettime(processor_clock_, &time);
  return time.tv_sec * ns_per_s + time.tv_nsec;
}

Status ThreadWorker::submit(const WorkerJob& job) {
  if (!running_ || state_.load(std::memory_order_acquire) != State::idle) return StatusCode::not_ready;
  job_ = job;
  begun_ns_ = used();
  state_.store(State::working, std::memory_order_release);
  sem_post(&wake_);
  return {};
}

WorkerProgress ThreadWorker::ask() {
  if (patient_) finish();
  const State state = state_.load(std::memory_order_acquire);
  if (state == State::idle) return WorkerProgress::idle;
  if (state == State::working) return stuck() ? WorkerProgress::stuck : WorkerProgress::working;
  state_.store(State::idle, std::memory_order_relaxed);
  return WorkerProgress::done;
}

void ThreadWorker::finish() {
  // bound: the job's longest time, after which it is stuck
  while (state_.load(std::memory_order_acquire) == State::working && !stuck()) wait_a_while(ended_);
}

bool ThreadWorker::stop() {
  if (!running_) return true;
  finish();
  if (state_.load(std::memory_order_acquire) == State::working) return false;
  running_ = false;
  leaving_.store(true, std::memory_order_release);
  sem_post(&wake_);
  pthread_join(thread_, nullptr);
  return true;
}

}  // namespace ilp
