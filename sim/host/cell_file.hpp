// Reads tables from text files (CSV with any usual separator), as people and spreadsheets save them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace ilp::host {

struct TextLine {
  int number = 0;  ///< line number in the file, from 1
  std::string text;
};

struct TextLines {
  std::vector<TextLine> lines;  ///< unchanged, without empty lines and comments (#)
  bool marked = false;          ///< the file begins with a byte-order mark, which is skipped
};

/// Throws std::runtime_error if the file cannot be read.
[[nodiscard]] TextLines read_text_lines(const std::filesystem::path& path);

struct CellLine {
  int number = 0;  ///< line number in the file, from 1
  std::vector<std::string> cells;
};

struct CellFile {
  std::vector<CellLine> lines;
  bool plain = true;  ///< separated by commas, without a byte-order mark and quotes
};

/// Splits lines into cells. The first line decides whether commas, semicolons or tabs separate them; a later line
/// changes from commas to semicolons if it has more of these. Where the separator is no comma, a comma in a number is
/// its decimal point. Blanks around cells are removed. Quotes are removed, and separators between them are text (RFC
/// 4180).
[[nodiscard]] CellFile cells_of(const TextLines& text);

}  // namespace ilp::host
