// Writes tables in Markdown.
#pragma once

#include <string>
#include <vector>

#include "cfg/mission.hpp"

namespace ilp::docgen {

using Cells = std::vector<std::string>;

/// The text with `|`, which would end a cell, escaped.
std::string cell(const std::string& text);
/// The text as code in a cell.
std::string code(const std::string& text);
std::string table_head(const Cells& titles);
std::string table_row(const Cells& cells);
/// The number with up to ten significant digits.
std::string number(double value);

// Cells of tables that state the values of parameters and of record fields.

/// Whether the meaning is more than the name with blanks for underscores.
[[nodiscard]] bool says_more(const EnumValue& value);

/// "0 `regular` (at a constant interval), 1 `forecast` (...)".
[[nodiscard]] std::string values_text(EnumValues values);

/// "0.5…0.98"; empty for a choice, whose names `meaning_cell` lists.
[[nodiscard]] std::string range_cell(const ParameterInfo& info);

/// A value as in a mission file: a number, or the name of a choice.
[[nodiscard]] std::string value_cell(const ParameterInfo& info, double value);

/// The description of a parameter or a field, with its choices or its enumerated values.
[[nodiscard]] std::string meaning_cell(const ParameterInfo& info);
[[nodiscard]] std::string meaning_cell(const FieldInfo& field);

/// The field's description; empty if it only repeats the name.
[[nodiscard]] std::string description_cell(const FieldInfo& field);

}  // namespace ilp::docgen
