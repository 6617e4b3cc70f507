// Follows a flight whose files arrive: repeats the run of ilp-ground for new files, and publishes the changes.
#pragma once

#include <chrono>
#include <iosfwd>
#include <optional>

#include "sim/ground/ground_run.hpp"
#include "sim/ground/serve/state_log.hpp"
#include "sim/ground/serve/static_files.hpp"

namespace ilp::serve {

class LiveFlight {
 public:
  explicit LiveFlight(ground::GroundOptions options) : options_(std::move(options)), static_files_(options_.out) {}
  /// Runs ilp-ground once if anything has changed since the call before. A run that fails is repeated at the next
  /// change or after a minute; until then the item "run" has its error. An empty folder is no error before the first
  /// run. Writes a line for each update to `messages`.
  void look(std::ostream& messages);

  [[nodiscard]] const StateLog& state() const { return state_; }
  [[nodiscard]] StateLog& state() { return state_; }
  [[nodiscard]] const StaticFiles& static_files() const { return static_files_; }

 private:
  using Clock = std::chrono::steady_clock;
  void run(std::ostream& messages);

  ground::GroundOptions options_;
  std::optional<std::uint64_t> known_;  ///< digest of the last run's inputs
  Clock::time_point again_ = Clock::time_point::max();
  std::size_t updates_ = 0;
  bool greeted_ = false;  ///< the message that it waits for the first file was written
  StateLog state_;
  StaticFiles static_files_;
};

}  // namespace ilp::serve
