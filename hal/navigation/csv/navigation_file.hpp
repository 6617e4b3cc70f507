// Reads navigation samples from a text file of comma-separated values.
#pragma once

#include <array>

#include "hal/navigation/navigation.hpp"
#include "hal/posix/buffered_reader.hpp"

namespace ilp {

/// docs/navigation.md lists the columns. The first line names them, in any order, with their units; an unknown name is
/// refused, so that no unit is guessed. A cell may be empty. Lines that begin with # are comments, and a byte-order
/// mark is skipped. A time is a number of seconds, or a date of ISO 8601 with its zone, which becomes seconds since
/// 1970 (fsw/base/date_text.hpp).
class NavigationFile final : public NavigationSource {
 public:
  NavigationFile() = default;
  ~NavigationFile();
  NavigationFile(const NavigationFile&) = delete;
  NavigationFile& operator=(const NavigationFile&) = delete;

  /// Opens the file and reads the names of the columns. Returns `not_found` or `io_error` (first value: errno) if the
  /// file cannot be opened, and `truncated` if it is empty. Returns `parse_error` (first value: line, second: column,
  /// both from 1) if a column is unknown or comes twice. The column is 0 if the time, or one of the columns of a
  /// quantity or its standard deviation, is missing.
  Status open(const char* path);
  /// Returns, besides the statuses of the interface, `parse_error` (first value: line, second: column) for a malformed
  /// line, which is skipped. Returns `time_not_monotonic` (first value: line, second: ns) for a line that is earlier
  /// than its predecessor by that time; it is skipped too.
  Status next(TimeNs now, NavigationSample& sample) override;
  [[nodiscard]] bool recorded() const override { return true; }

 private:
  static constexpr std::size_t max_columns = 24;

  Status read_line();
  Status read_header();
  Status read_sample();

  int file_ = -1;
  BufferedReader reader_;
  char line_[512] = {};
  std::int64_t line_number_ = 0;
  std::array<std::size_t, max_columns> quantity_{};  ///< index of each of the file's columns in navigation_columns()
  std::size_t columns_ = 0;
  NavigationSample sample_;  ///< the next sample, if `waiting_`
  bool waiting_ = false;
  bool ended_ = true;
  TimeNs latest_ns_ = 0;
};

}  // namespace ilp
