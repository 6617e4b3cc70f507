// Reports the progress of long work to the user of a program.
#pragma once

#include <chrono>
#include <cstddef>
#include <ostream>
#include <string>

namespace ilp::host {

/// `rewritten`: one line of a terminal is rewritten. `lines`: a file or a pipe gets a new line from time to time.
enum class ProgressStyle { rewritten, lines };

/// `rewritten` if `messages` is std::cerr on a terminal, else `lines`.
[[nodiscard]] ProgressStyle progress_style(const std::ostream& messages);

/// `merging: 12 of 70, about 8 s left`. The estimate assumes that the other steps take as long as the `done` steps took
/// in `elapsed_s` seconds. It is left out if no step or every step is done. `all` is 0 if the number of steps is not
/// known.
[[nodiscard]] std::string progress_text(const std::string& what, std::size_t done, std::size_t all, double elapsed_s);

/// Reports the progress of work in steps. Short work reports nothing.
class Progress {
 public:
  Progress(std::ostream& messages, std::string what) : Progress(messages, std::move(what), progress_style(messages)) {}
  Progress(std::ostream& messages, std::string what, ProgressStyle style);
  /// A copy has its own clock and line.
  Progress(const Progress& other) : Progress(other.messages_, other.what_, other.style_) {}
  Progress& operator=(const Progress&) = delete;
  ~Progress() { end(); }

  /// Reports that `done` of `all` steps are finished now.
  void operator()(std::size_t done, std::size_t all) { update(done, all, seconds_since_begin()); }
  /// Reports the same at `elapsed_s` seconds after the begin of the work.
  void update(std::size_t done, std::size_t all, double elapsed_s);
  /// Clears the line of a terminal for other messages.
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

/// Reports work in phases: a call names the phase that begins. A terminal shows every phase; a file or a pipe gets
/// those that begin 3 s or more after the work.
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
