// Navigation samples from a text file of comma-separated values.
#pragma once

#include <array>

#include "hal/navigation/navigation.hpp"
#include "hal/posix/buffered_reader.hpp"

namespace ilp {

/// The first line names the columns, in any order, with their units; an unknown name is refused, so that no unit is
/// guessed. A cell may be empty. Lines that begin with # are comments, and a byte-order mark is skipped. A time may be
/// a date of ISO 8601 with its zone (fsw/base/date_text.hpp); it counts from 1970. docs/navigation.md has the columns.
class NavigationFile final : public NavigationSource {
 public:
  NavigationFile() = default;
  ~NavigationFile();
  NavigationFile(const NavigationFile&) = delete;
  NavigationFile& operator=(const NavigationFile&) = delete;

  /// `not_found`, `io_error`; `parse_error` (a = line, b = column, from 1) for an unknown column or one that comes
  /// twice; (b = 0) for a quantity without all of its columns and its sigma, or no time; `truncated` for an empty file.
  Status open(const char* path);
  /// Besides the statuses of the interface: `parse_error` (a = line, b = column) for a line that was left out, and
  /// `time_not_monotonic` (a = line, b = ns) for one that is earlier than its predecessor.
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
  std::array<std::size_t, max_columns> quantity_{};  ///< of each column, an index into the table of columns
  std::size_t columns_ = 0;
  NavigationSample sample_;  ///< the next one, when `waiting_`
  bool waiting_ = false;
  bool ended_ = true;
  TimeNs latest_ns_ = 0;
};

}  // namespace ilp
