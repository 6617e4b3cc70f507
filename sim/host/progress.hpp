// Reports the progress of long work to a person who waits.
#pragma once

#include <chrono>
#include <ostream>
#include <string>

namespace ilp::host {

/// Writes a line every few seconds; short work writes none.
class Progress {
 public:
  Progress(std::ostream& messages, std::string what) : messages_(messages), what_(std::move(what)) {}
  void operator()(std::size_t done, std::size_t all) {
    const auto now = Clock::now();
    if (now - told_ < interval || done >= all) return;
    told_ = now;
    messages_ << what_ << ": " << done << " of " << all << "\n" << std::flush;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::seconds interval{3};
  std::ostream& messages_;
  std::string what_;
  Clock::time_point told_ = Clock::now();
};

/// For work in phases: names the phase that begins, unless the work has begun a few seconds ago only.
class LongPhases {
 public:
  explicit LongPhases(std::ostream& messages) : messages_(messages) {}
  void operator()(const std::string& phase) {
    if (Clock::now() - begun_ > patience) messages_ << phase << "\n" << std::flush;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::seconds patience{3};
  std::ostream& messages_;
  Clock::time_point begun_ = Clock::now();
};

}  // namespace ilp::host
