// Tables in text files as people and their spreadsheets save them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace ilp::host {

struct CellLine {
  int number = 0;  ///< of the line in the file, from 1
  std::vector<std::string> cells;
};

struct CellFile {
  std::vector<CellLine> lines;  ///< without empty ones and those that begin with #
  bool plain = true;            ///< commas and UTF-8 without a byte-order mark, nothing in quotes
};

/// Commas, semicolons or tabs between the cells, by the first line; with semicolons and tabs a comma in a number is a
/// decimal point. Skipped: a byte-order mark, blanks around cells, and quotes. std::runtime_error where the file cannot
/// be read.
[[nodiscard]] CellFile read_cell_file(const std::filesystem::path& path);

}  // namespace ilp::host
