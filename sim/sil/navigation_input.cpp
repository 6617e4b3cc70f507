#include "sim/sil/navigation_input.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iomanip>
#include <ostream>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>

#include "fsw/base/date_text.hpp"
#include "fsw/base/navigation_sample.hpp"
#include "fsw/vision/navigation/sample_filter.hpp"
#include "sim/host/cell_file.hpp"
#include "sim/host/files.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::sil {
namespace fs = std::filesystem;
namespace {

/// Three years: no flight is as long, and no time since 1970 as short.
constexpr double longest_flight_s = 1e8;
constexpr double window_s = 1e-9 * static_cast<double>(navigation::window_ns);

enum class Kind { none, of_the_flight, utc, of_the_clock };

struct MeasuredLine {
  std::vector<std::string> cells;
  Kind kind = Kind::none;
  double time_s = 0;  ///< since the first image, or since 1970
};

struct Table {
  std::vector<std::string> names;
  std::size_t time_column = 0;
  std::vector<MeasuredLine> lines;
  bool plain = true;  ///< the flight reads it as it is
  bool dated = false;
};

[[noreturn]] void refuse_navigation(const fs::path& file, const std::string& what) {
  throw std::runtime_error("navigation " + file.string() + ": " + what + "; check the file (docs/navigation.md)");
}

void check_names(const fs::path& file, const std::vector<std::string>& names) {
  const auto columns = navigation_columns();
  std::string known;
  for (const NavigationColumn& column : columns) known += (known.empty() ? "" : ", ") + std::string(column.name);
  std::set<std::string> present;
  for (const std::string& name : names) {
    const auto is_name = [&](const NavigationColumn& column) { return name == column.name; };
    if (std::none_of(columns.begin(), columns.end(), is_name))
      refuse_navigation(file, "the column \"" + name + "\" is not known; these are: " + known);
    if (!present.insert(name).second) refuse_navigation(file, "the column " + name + " stands twice");
  }
  if (!present.contains(columns[0].name))
    refuse_navigation(file, std::string("the column ") + columns[0].name + " is missing");
  for (const NavigationColumn& column : columns) {
    if (present.contains(column.name)) continue;
    for (const NavigationColumn& other : columns) {
      if (other.group == column.group && present.contains(other.name))
        refuse_navigation(file,
                          std::string("the column ") + column.name + " is missing, which belongs to " + other.name);
    }
  }
}

bool read_number(const std::string& text, double& value) {
  char* end = nullptr;
  value = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0' && std::isfinite(value);
}

void read_time(MeasuredLine& line, std::size_t column) {
  if (column >= line.cells.size()) return;
  const std::string& text = line.cells[column];
  if (read_number(text, line.time_s)) {
    line.kind = line.time_s > longest_flight_s ? Kind::utc : Kind::of_the_flight;
  } else {
    TimeNs since_1970 = 0;
    const DateClock clock = read_date(text.c_str(), since_1970);
    line.time_s = 1e-9 * static_cast<double>(since_1970);
    line.kind = clock == DateClock::none ? Kind::none : clock == DateClock::utc ? Kind::utc : Kind::of_the_clock;
  }
}

bool since_1970(const std::vector<double>& images) {
  return !images.empty() && images.front() > longest_flight_s;
}

Table read_table(const fs::path& file) {
  const host::CellFile text = host::cells_of(host::read_text_lines(file));
  if (text.lines.empty()) refuse_navigation(file, "no line with the names of columns");
  Table table;
  table.plain = text.plain;
  table.names = text.lines.front().cells;
  check_names(file, table.names);
  const auto found = std::find(table.names.begin(), table.names.end(), navigation_columns()[0].name);
  table.time_column = static_cast<std::size_t>(found - table.names.begin());
  for (std::size_t i = 1; i < text.lines.size(); ++i) {
    MeasuredLine& line = table.lines.emplace_back();
    line.cells = text.lines[i].cells;
    const auto has_comma = [](const std::string& cell) { return cell.find(',') != std::string::npos; };
    const auto odd = std::find_if(line.cells.begin(), line.cells.end(), has_comma);
    if (odd != line.cells.end())
      refuse_navigation(file, "line " + std::to_string(text.lines[i].number) + ": \"" + *odd +
                                  "\" has a comma; a decimal point, or semicolons between the cells, expected");
    read_time(line, table.time_column);
    table.dated = table.dated || line.kind == Kind::of_the_clock ||
                  (line.kind == Kind::utc && line.cells[table.time_column].find(':') != std::string::npos);
  }
  return table;
}

std::vector<double> times_of(const std::vector<host::StripFrame>& frames) {
  std::vector<double> times;
  for (const host::StripFrame& frame : frames) times.push_back(1e-9 * static_cast<double>(frame.time_ns));
  return times;
}

std::size_t near_images(const std::vector<double>& sorted, const std::vector<double>& images, double later_s) {
  return static_cast<std::size_t>(std::count_if(images.begin(), images.end(), [&](double image) {
    const auto after = std::lower_bound(sorted.begin(), sorted.end(), image + later_s - window_s);
    return after != sorted.end() && *after <= image + later_s + window_s;
  }));
}

std::vector<double> sorted_times(const std::vector<MeasuredLine>& lines, Kind kind) {
  std::vector<double> times;
  for (const MeasuredLine& line : lines) {
    if (line.kind == kind) times.push_back(line.time_s);
  }
  std::sort(times.begin(), times.end());
  return times;
}

/// Seconds by which the measurements' clock is ahead of that of the images; none where no zone fits, or several.
std::optional<double> zone_by_times(const std::vector<double>& measured, const std::vector<double>& images,
                                    double first_image_s) {
  constexpr int quarter_s = 900, most_quarters = 14 * 4;
  std::size_t best = 0, fitting = 0;
  double zone_s = 0;
  for (int quarters = -most_quarters; quarters <= most_quarters; ++quarters) {
    const std::size_t near = near_images(measured, images, first_image_s + quarters * quarter_s);
    if (near == 0) continue;
    if (near == best) ++fitting;
    if (near <= best) continue;
    best = near;
    fitting = 1;
    zone_s = quarters * quarter_s;
  }
  return fitting == 1 ? std::optional(zone_s) : std::nullopt;
}

/// What is taken from the times of this kind; none where it cannot be known, which is told.
std::optional<double> begin_of(Kind kind, const Table& table, const std::vector<double>& images,
                               const std::optional<StripEpoch>& epoch, std::ostream& messages) {
  const std::vector<double> measured = sorted_times(table.lines, kind);
  if (measured.empty()) return std::nullopt;
  const std::string lines = host::counted(measured.size(), "line");
  if (!epoch) {
    messages << "navigation: " << lines << " with a date or a time since 1970 cannot be used, because the images state "
             << "no time that was used: give the times in seconds since the first image\n";
    return std::nullopt;
  }
  const double first_s = 1e-9 * static_cast<double>(epoch->time_ns);
  if (epoch->utc == (kind == Kind::utc)) return first_s;
  const auto zone = zone_by_times(measured, images, first_s);
  if (!zone) {
    messages << "navigation: " << lines << " with a date or a time since 1970 cannot be used, because the clock of the "
             << "images is in a zone that they do not state, and none or several fit: give the times in seconds since "
             << "the first image\n";
    return std::nullopt;
  }
  messages << "navigation: the clock of the images is taken to be " << host::fixed(-*zone / 3600, 2)
           << " h ahead of that of the measurements, the only zone that fits\n";
  return first_s + *zone;
}

void write_table(const Table& table, const fs::path& made) {
  std::ostringstream out;
  for (std::size_t i = 0; i < table.names.size(); ++i) out << (i > 0 ? "," : "") << table.names[i];
  out << "\n" << std::fixed << std::setprecision(6);
  for (const MeasuredLine& line : table.lines) {
    if (line.kind != Kind::of_the_flight) continue;
    for (std::size_t i = 0; i < line.cells.size(); ++i) {
      out << (i > 0 ? "," : "");
      if (i == table.time_column)
        out << line.time_s;
      else
        out << line.cells[i];
    }
    out << "\n";
  }
  host::write_file(made, out.str());
}

void report_coverage(const fs::path& given, const Table& table, const std::vector<double>& images,
                     std::ostream& messages) {
  const auto unreadable = std::count_if(table.lines.begin(), table.lines.end(),
                                        [](const MeasuredLine& line) { return line.kind == Kind::none; });
  if (unreadable > 0)
    messages << "navigation: " << host::counted(static_cast<std::size_t>(unreadable), "line") << " of "
             << given.string() << " cannot be used, for the time\n";
  const std::vector<double> measured = sorted_times(table.lines, Kind::of_the_flight);
  if (images.empty() || near_images(measured, images, 0) > 0) return;
  messages << "navigation: no measurement of " << given.string() << " lies within " << host::brief(window_s)
           << " s of an image, so none is used: ";
  if (measured.empty()) {
    messages << "none has a time that can be used\n";
    return;
  }
  const auto [first, last] = std::minmax_element(images.begin(), images.end());
  messages << "the measurements are from " << host::fixed(measured.front(), 1) << " to "
           << host::fixed(measured.back(), 1) << " s, the images from " << host::fixed(*first, 1) << " to "
           << host::fixed(*last, 1) << " s\n";
}

}  // namespace

fs::path prepare_navigation(const fs::path& given, const std::vector<host::StripFrame>& frames,
                            const std::optional<StripEpoch>& epoch, const fs::path& made, std::ostream& messages) {
  Table table = read_table(given);
  const std::vector<double> images = times_of(frames);
  // A list of images may count from 1970 too.
  const bool same_count = since_1970(images);
  const std::optional<StripEpoch> begin_of_images = same_count ? StripEpoch{0, true} : epoch;
  for (const Kind kind : {Kind::utc, Kind::of_the_clock}) {
    const bool any = !sorted_times(table.lines, kind).empty();
    const auto begin = begin_of(kind, table, images, begin_of_images, messages);
    for (MeasuredLine& line : table.lines) {
      if (line.kind != kind) continue;
      line.kind = begin ? Kind::of_the_flight : Kind::none;
      if (begin) line.time_s -= *begin;
    }
    table.plain = table.plain && (!any || (same_count && !table.dated));
  }
  report_coverage(given, table, images, messages);
  if (table.plain) return given;
  write_table(table, made);
  messages << "navigation: " << given.string() << " is read as " << made.string() << "\n";
  return made;
}

}  // namespace ilp::sil
