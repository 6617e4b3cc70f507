// Where a campaign stands, for somebody who watches or for a log.
#pragma once

#include <chrono>
#include <ostream>
#include <string>

namespace ilp::batch {

/// One line that is overwritten on a terminal; elsewhere a line for each tenth of the work.
class Progress {
 public:
  Progress(std::ostream& out, bool terminal, std::size_t total, std::size_t done_before, std::size_t parallel);

  void ended(const std::string& job, const std::string& failure);
  /// Once a second, or so.
  void tick(std::size_t running);
  /// Ends the overwritten line.
  void close();

 private:
  [[nodiscard]] std::string text() const;
  void clear();

  std::ostream* out_;
  bool terminal_, shown_ = false;
  std::size_t total_, before_, parallel_;
  std::size_t done_ = 0, failed_ = 0, tenths_ = 0;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace ilp::batch
