// Markdown tables whose cells may hold any text.
#pragma once

#include <string>
#include <vector>

namespace ilp::docgen {

using Cells = std::vector<std::string>;

/// The text with characters that end a cell escaped; empty text stays empty.
std::string cell(const std::string& text);
/// The text as code.
std::string code(const std::string& text);
std::string table_head(const Cells& titles);
std::string table_row(const Cells& cells);
/// The number with the fewest digits that give the same value when it is read again.
std::string number(double value);

}  // namespace ilp::docgen
