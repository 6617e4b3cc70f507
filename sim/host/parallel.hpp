// Runs independent tasks on all cores of the host.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace ilp::host {

/// Calls work(k) once for every k in [0, count), in any order, from `threads` threads (0: one per core, 16 at most).
/// After an exception no further k begins; the first exception is thrown to the caller. Results do not depend on the
/// number of threads if each k writes to its own memory.
template <typename Work>
void for_each_parallel(std::size_t count, Work work, std::size_t threads = 0) {
  std::atomic<std::size_t> next{0};
  std::exception_ptr error;
  std::mutex error_mutex;
  const auto run = [&] {
    try {
      for (std::size_t k = next++; k < count; k = next++) work(k);
    } catch (...) {
      next = count;
      const std::lock_guard lock(error_mutex);
      if (!error) error = std::current_exception();
    }
  };
  if (threads == 0) threads = std::clamp<std::size_t>(std::thread::hardware_concurrency(), 1, 16);
  {
    std::vector<std::jthread> others;
    for (std::size_t k = 1; k < std::min(threads, count); ++k) others.emplace_back(run);
    run();
  }
  if (error) std::rethrow_exception(error);
}

}  // namespace ilp::host
