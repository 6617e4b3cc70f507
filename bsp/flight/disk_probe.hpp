// Tests in a thread of its own whether the disk of a flight in memory works again. A failing disk may block a call for
// minutes.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "bsp/flight/memory_copy.hpp"
#include "cfg/limits.hpp"
#include "fsw/base/time.hpp"
#include "hal/posix/measured_stack.hpp"

namespace ilp {

inline constexpr TimeNs disk_probe_interval_ns = 30 * ns_per_s;
/// Size of the thread's stack with the protected page at its end.
inline constexpr std::size_t disk_probe_stack_bytes = limits::worker_stack_bytes + stack_page_bytes;

class DiskProbe {
 public:
  /// Starts the thread, which calls try_disk() for the database at `path` every `interval`. Each copy of records that
  /// waits beside the database makes the interval four times as long, because an earlier move has not led back to the
  /// disk. `path`, this object and `stack` (disk_probe_stack_bytes, from the beginning of a page) last as long as the
  /// process. Call it before the heap is sealed. Returns 0, or an errno if there is no thread.
  int begin(const char* path, std::int64_t free_bytes, std::span<std::byte> stack,
            TimeNs interval = disk_probe_interval_ns);
  /// Whether the disk works. It is not tested again until probe_again().
  [[nodiscard]] bool found() const { return found_.load(std::memory_order_acquire); }
  /// Continues to test the disk.
  void probe_again() { found_.store(false, std::memory_order_release); }

 private:
  static void* enter(void* probe);
  void probe();

  const char* path_ = nullptr;
  std::int64_t free_bytes_ = 0;
  TimeNs interval_ns_ = 0;
  std::atomic<bool> found_{false};
};

}  // namespace ilp
