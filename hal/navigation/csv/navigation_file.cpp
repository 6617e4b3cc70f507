#include "hal/navigation/csv/navigation_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>

#include "fsw/base/date_text.hpp"

namespace ilp {
namespace {

constexpr double latest_s = 9e9;  // of mission time in 64 bits of nanoseconds

using Group = NavigationGroup;
constexpr std::size_t known_columns = navigation_column_count;

std::size_t find_column(const char* name) {
  std::size_t i = 0;
  while (i < known_columns && std::strcmp(navigation_columns()[i].name, name) != 0) ++i;
  return i;
}

bool read_number(const char* text, double& value) {
  char* rest = nullptr;
  value = std::strtod(text, &rest);
  return *rest == 0 && std::isfinite(value);
}

/// Cuts the cell at `text` out of its line, without blanks around it. Returns the beginning of the next one, or null.
char* cut_cell(char*& text) {
  char* end = std::strchr(text, ',');
  char* const next = end != nullptr ? end + 1 : nullptr;
  if (end == nullptr) end = text + std::strlen(text);
  while (*text == ' ' || *text == '\t') ++text;  // bound: the text; its end is no blank
  while (end > text && (end[-1] == ' ' || end[-1] == '\t' || end[-1] == '\r')) --end;
  *end = 0;
  return next;
}

}  // namespace

NavigationFile::~NavigationFile() {
  if (file_ >= 0) close(file_);
}

Status NavigationFile::open(const char* path) {
  if (file_ >= 0) close(file_);
  ended_ = true;
  file_ = ::open(path, O_RDONLY | O_CLOEXEC);
  if (file_ < 0) return errno == ENOENT ? Status{StatusCode::not_found} : Status{StatusCode::io_error, errno};
  reader_.attach(file_);
  line_number_ = 0;
  waiting_ = false;
  latest_ns_ = std::numeric_limits<TimeNs>::min();
  ILP_TRY(read_header());
  ended_ = false;
  return {};
}

/// The next line that is no comment and not empty; `parse_error` for one that is too long.
Status NavigationFile::read_line() {
  // Bounded by the file: every turn consumes a line of it.
  for (;;) {
    ++line_number_;
    std::size_t size = 0;
    const Status status = reader_.line(line_, size);
    // A line with a zero octet is shorter than it seems.
    const bool cut = status.ok() && std::strlen(line_) != size;
    if (cut || status.is(StatusCode::parse_error)) return {StatusCode::parse_error, line_number_};
    ILP_TRY(status);
    constexpr char byte_order_mark[] = "\xEF\xBB\xBF";
    constexpr std::size_t mark_size = sizeof(byte_order_mark) - 1;
    if (line_number_ == 1 && std::strncmp(line_, byte_order_mark, mark_size) == 0)
      std::memmove(line_, line_ + mark_size, size + 1 - mark_size);
    const std::size_t blank = std::strspn(line_, " \t\r");
    if (line_[blank] != 0 && line_[blank] != '#') return {};
  }
}

Status NavigationFile::read_header() {
  const Status status = read_line();
  if (status.is(StatusCode::end_of_stream)) return {StatusCode::truncated, 0};
  ILP_TRY(status);
  std::array<bool, known_columns> present{};
  columns_ = 0;
  for (char* text = line_; text != nullptr;) {  // bound: the cells of the line
    char* const next = cut_cell(text);
    const std::size_t column = find_column(text);
    const Status wrong{StatusCode::parse_error, line_number_, static_cast<std::int64_t>(columns_) + 1};
    if (column == known_columns || present[column]) return wrong;
    present[column] = true;
    quantity_[columns_++] = column;
    text = next;
  }
  for (std::size_t i = 0; i < known_columns; ++i) {
    const auto together = [&](std::size_t k) {
      return navigation_columns()[i].group == navigation_columns()[k].group && present[k];
    };
    bool any = i == 0;
    for (std::size_t k = 0; k < known_columns; ++k) any = any || together(k);
    if (any && !present[i]) return {StatusCode::parse_error, line_number_};
  }
  return {};
}

Status NavigationFile::read_sample() {
  sample_ = {};
  std::array<bool, static_cast<std::size_t>(Group::count)> empty{};
  const auto is_empty = [&empty](Group group) { return empty[static_cast<std::size_t>(group)]; };
  char* text = line_;
  for (std::size_t i = 0; i < columns_; ++i) {
    const Status wrong{StatusCode::parse_error, line_number_, static_cast<std::int64_t>(i) + 1};
    if (text == nullptr) return wrong;
    char* const next = cut_cell(text);
    const NavigationColumn& column = navigation_columns()[quantity_[i]];
    if (*text == 0) {
      empty[static_cast<std::size_t>(column.group)] = true;
    } else {
      double number = 0;
      const bool is_time = column.value == nullptr, is_number = read_number(text, number);
      if (is_time) {
        const bool dated = !is_number && read_date(text, sample_.time_ns) == DateClock::utc;
        if (!dated && (!is_number || std::fabs(number) > latest_s)) return wrong;
        if (!dated) sample_.time_ns = static_cast<TimeNs>(number * 1e9 + (number < 0 ? -0.5 : 0.5));
      } else {
        if (!is_number) return wrong;
        *column.value(sample_) = number;
      }
    }
    text = next;
  }
  if (text != nullptr || is_empty(Group::time)) {
    return {StatusCode::parse_error, line_number_, static_cast<std::int64_t>(columns_)};
  }
  if (is_empty(Group::height)) sample_.height_sigma_m = 0;
  if (is_empty(Group::attitude)) sample_.tilt_sigma_rad = sample_.heading_sigma_rad = 0;
  if (is_empty(Group::heading)) sample_.heading_sigma_rad = 0;
  if (is_empty(Group::horizontal)) sample_.horizontal_sigma_m = sample_.vertical_sigma_m = 0;
  if (is_empty(Group::vertical)) sample_.vertical_sigma_m = 0;
  if (is_empty(Group::velocity)) sample_.velocity_sigma_m_s = 0;
  return {};
}

Status NavigationFile::next(TimeNs now, NavigationSample& sample) {
  if (!waiting_) {
    if (ended_) return StatusCode::end_of_stream;
    const Status line = read_line();
    if (line.is(StatusCode::parse_error)) return line;
    if (!line.ok()) ended_ = true;
    ILP_TRY(line);
    ILP_TRY(read_sample());
    if (sample_.time_ns < latest_ns_)
      return {StatusCode::time_not_monotonic, line_number_, latest_ns_ - sample_.time_ns};
    latest_ns_ = sample_.time_ns;
    waiting_ = true;
  }
  if (sample_.time_ns > now) return StatusCode::not_ready;
  waiting_ = false;
  sample = sample_;
  return {};
}

}  // namespace ilp
