#include "sim/host/cell_file.hpp"

#include <algorithm>
#include <sstream>
#include <string_view>

#include "sim/host/files.hpp"

namespace ilp::host {
namespace {

constexpr std::string_view blanks = " \t\r", byte_order_mark = "\xEF\xBB\xBF";

std::string without_blanks(std::string_view text) {
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(blanks) - first + 1));
}

/// Two quotes inside quotes are one (RFC 4180).
std::vector<std::string> cells_of_line(const std::string& line, char separator) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') {
      if (quoted && i + 1 < line.size() && line[i + 1] == '"') {
        cells.back() += line[++i];
        continue;
      }
      quoted = !quoted;
    } else if (line[i] == separator && !quoted) {
      cells.emplace_back();
    } else {
      cells.back() += line[i];
    }
  }
  for (std::string& cell : cells) cell = without_blanks(cell);
  return cells;
}

char separator_in(const std::string& line) {
  for (const char separator : {';', '\t'}) {
    if (line.find(separator) != std::string::npos && line.find(',') == std::string::npos) return separator;
  }
  return ',';
}

void mend_decimal_comma(std::string& cell) {
  const bool number = !cell.empty() && cell.find_first_not_of("0123456789+-,eE") == std::string::npos;
  if (number && std::count(cell.begin(), cell.end(), ',') == 1) cell[cell.find(',')] = '.';
}

}  // namespace

TextLines read_text_lines(const std::filesystem::path& path) {
  const std::vector<std::uint8_t> bytes = read_file(path);
  std::string text(bytes.begin(), bytes.end());
  TextLines file;
  file.marked = text.starts_with(byte_order_mark);
  if (file.marked) text.erase(0, byte_order_mark.size());
  std::istringstream in(text);
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    const std::size_t first = line.find_first_not_of(blanks);
    if (first != std::string::npos && line[first] != '#') file.lines.push_back({number, line});
  }
  return file;
}

CellFile cells_of(const TextLines& text) {
  CellFile file;
  file.plain = !text.marked;
  char separator = '\0';
  for (const auto& [number, line] : text.lines) {
    const auto count = [&text = line](char c) { return std::count(text.begin(), text.end(), c); };
    if (separator == '\0') separator = separator_in(line);
    // The line of names may have been written by hand, with commas.
    if (separator == ',' && count(';') > count(',')) separator = ';';
    file.plain = file.plain && separator == ',' && line.find('"') == std::string::npos;
    file.lines.push_back({number, cells_of_line(line, separator)});
    if (separator == ',') continue;
    for (std::string& cell : file.lines.back().cells) mend_decimal_comma(cell);
  }
  return file;
}

}  // namespace ilp::host
