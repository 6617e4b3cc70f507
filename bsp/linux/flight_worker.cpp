#include "bsp/linux/flight_worker.hpp"

#include <cstdio>
#include <cstring>

#include "cfg/limits.hpp"
#include "hal/posix/measured_stack.hpp"

namespace ilp {
namespace {

// The C library for aarch64 refuses a smaller stack (PTHREAD_STACK_MIN).
static_assert(limits::worker_stack_bytes >= std::size_t{128} << 10U);

alignas(stack_page_bytes) std::byte stack[worker_region_bytes];

bool wants_thread(const Options& options) {
  if (options.worker == nullptr) return !options.virtual_time;
  return std::strcmp(options.worker, "thread") == 0;
}

}  // namespace

int FlightWorker::begin(const Options& options) {
  if (!wants_thread(options)) return 0;
  if (options.virtual_time) thread_.wait_for_answers();
  const int error = thread_.start(stack);
  has_thread_ = error == 0;
  return error;
}

void FlightWorker::end() {
  if (!has_thread_ || !thread_.stop()) return;
  const WorkerStats& stats = thread_.stats();
  std::printf("worker: %llu jobs, %lld ms of processor, longest %lld us, stack: peak %zu of %zu bytes\n",
              static_cast<unsigned long long>(stats.jobs), static_cast<long long>(stats.busy_ns / ns_per_ms),
              static_cast<long long>(stats.longest_ns / ns_per_us), stack_peak(stack), usable_stack(stack).size());
}

}  // namespace ilp
