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
/// As few digits as say it exactly enough to be typed back.
std::string number(double value);

}  // namespace ilp::docgen
