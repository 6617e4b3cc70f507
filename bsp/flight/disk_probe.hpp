// Looks for the disk of a flight in memory, in a thread of its own: a disk that fails may hold up a call for minutes.
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
/// The stack, and the page that guards its end.
inline constexpr std::size_t disk_probe_stack_bytes = limits::worker_stack_bytes + stack_page_bytes;

class DiskProbe {
 public:
  /// Begins to look (try_disk) for the disk of the database at `path`: every `interval`, and four times as seldom for
  /// each copy that waits beside it, because then an earlier move has not led back to the disk. The text, and this
  /// object and `stack` (disk_probe_stack_bytes, from the beginning of a page) last as long as the process. Call it
  /// before the heap is sealed. Returns an errno; nothing is looked for then.
  int begin(const char* path, std::int64_t free_bytes, std::span<std::byte> stack,
            TimeNs interval = disk_probe_interval_ns);
  /// The disk serves. Looking has stopped, until probe_again().
  [[nodiscard]] bool found() const { return found_.load(std::memory_order_acquire); }
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
