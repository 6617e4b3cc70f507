#include "sim/tools/docgen/markdown.hpp"

#include <array>
#include <cstdio>

namespace ilp::docgen {

std::string cell(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '|') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

std::string code(const std::string& text) {
  return "`" + cell(text) + "`";
}

std::string table_row(const Cells& cells) {
  std::string row = "|";
  for (const std::string& content : cells) row += content.empty() ? " |" : " " + content + " |";
  return row + "\n";
}

std::string table_head(const Cells& titles) {
  return table_row(titles) + table_row(Cells(titles.size(), "---"));
}

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.10g", value);
  return text.data();
}

}  // namespace ilp::docgen
