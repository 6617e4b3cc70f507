// Tables in text files as people and their spreadsheets save them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace ilp::host {

struct TextLine {
  int number = 0;  ///< of the line in the file, from 1
  std::string text;
};

struct TextLines {
  std::vector<TextLine> lines;  ///< as they are, without empty ones and those that begin with #
  bool marked = false;          ///< the file begins with a byte-order mark, which is skipped
};

/// std::runtime_error where the file cannot be read.
[[nodiscard]] TextLines read_text_lines(const std::filesystem::path& path);

struct CellLine {
  int number = 0;  ///< of the line in the file, from 1
  std::vector<std::string> cells;
};

struct CellFile {
  std::vector<CellLine> lines;
  bool plain = true;  ///< commas and UTF-8 without a byte-order mark, nothing in quotes
};

/// Commas, semicolons or tabs between the cells, by the first line; with semicolons and tabs a comma in a number is a
/// decimal point. Blanks around cells and quotes are skipped.
[[nodiscard]] CellFile cells_of(const TextLines& text);

}  // namespace ilp::host
