#include "bsp/linux/timing_report.hpp"

#include <cstdio>

namespace ilp {
namespace {

long long milliseconds(TimeNs time) {
  return static_cast<long long>(time / ns_per_ms);
}

/// Prints the bins that are not empty, by their upper ends.
void print_histogram(const char* name, const std::uint32_t (&bins)[limits::timing_bins]) {
  std::printf("  %s, below us:", name);
  for (std::size_t bin = 0; bin < limits::timing_bins; ++bin) {
    if (bins[bin] == 0) continue;
    if (bin + 1 < limits::timing_bins) {
      std::printf(" %lu: %lu", 1UL << bin, static_cast<unsigned long>(bins[bin]));
    } else {
      std::printf(" more: %lu", static_cast<unsigned long>(bins[bin]));
    }
  }
  std::printf("\n");
}

}  // namespace

void print_timing(const Executive& executive) {
  const TimingRecord& timing = executive.timing();
  std::printf(
      "minor frames: %lld, %lu overran, the longest took %lld ms, the latest began %lld us late; work level %u, %lu "
      "changes\n",
      static_cast<long long>(timing.frames), static_cast<unsigned long>(timing.overruns),
      milliseconds(timing.longest_ns), static_cast<long long>(timing.latest_ns / ns_per_us),
      static_cast<unsigned>(timing.degraded), static_cast<unsigned long>(timing.degraded_changes));
  print_histogram("late", timing.late);
  print_histogram("length", timing.used);
  for (const Stage& stage : schedule) {
    const ComponentStats& stats = executive.stats(stage.component);
    std::printf("  %s: %lu steps, %lld ms of processor, longest %lld us, %lu over budget\n", stage.name,
                static_cast<unsigned long>(stats.steps), milliseconds(stats.busy_ns),
                static_cast<long long>(stats.longest_ns / ns_per_us), static_cast<unsigned long>(stats.overruns));
  }
}

}  // namespace ilp
