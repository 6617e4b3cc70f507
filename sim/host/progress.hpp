// Reports the progress of long work to a person who waits.
#pragma once

#include <chrono>
#include <cstddef>
#include <ostream>
#include <string>

namespace ilp::host {

/// A terminal has one line that is rewritten; a file or a pipe gets a whole line now and then.
enum class ProgressStyle { rewritten, lines };

/// Rewritten if `messages` is the error stream of a terminal.
[[nodiscard]] ProgressStyle progress_style(const std::ostream& messages);

/// `merging: 12 of 70, about 8 s left`. The estimate takes all pieces to be as long as those done in `elapsed_s`
/// seconds; without any, and with all of them done, there is none. With `all` 0 the number of pieces is not known.
[[nodiscard]] std::string progress_text(const std::string& what, std::size_t done, std::size_t all, double elapsed_s);

/// The line of work in pieces. Short work has none.
class Progress {
 public:
  Progress(std::ostream& messages, std::string what) : Progress(messages, std::move(what), progress_style(messages)) {}
  Progress(std::ostream& messages, std::string what, ProgressStyle style);
  /// A copy reports for itself.
  Progress(const Progress& other) : Progress(other.messages_, other.what_, other.style_) {}
  Progress& operator=(const Progress&) = delete;
  ~Progress() { end(); }

  /// `done` of `all` pieces are finished, now.
  void operator()(std::size_t done, std::size_t all) { update(done, all, seconds_since_begin()); }
  /// The same `elapsed_s` seconds after the work began.
  void update(std::size_t done, std::size_t all, double elapsed_s);
  /// Clears the line of a terminal, for what comes next.
  void end();

 private:
  [[nodiscard]] double seconds_since_begin() const;

  std::ostream& messages_;
  std::string what_;
  ProgressStyle style_;
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  double reported_s_ = 0;
  bool open_ = false;
};

/// For work in phases: names the phase that begins, unless the work has begun a few seconds ago only.
class LongPhases {
 public:
  explicit LongPhases(std::ostream& messages) : messages_(messages), style_(progress_style(messages)) {}
  LongPhases(const LongPhases& other) : LongPhases(other.messages_) {}
  LongPhases& operator=(const LongPhases&) = delete;
  ~LongPhases();
  void operator()(const std::string& phase);

 private:
  std::ostream& messages_;
  ProgressStyle style_;
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  bool open_ = false;
};

}  // namespace ilp::host
