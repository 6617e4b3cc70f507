// Tables in Markdown whose cells may hold any text.
#pragma once

#include <string>
#include <vector>

#include "cfg/mission.hpp"

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

// Cells of tables that state the values of parameters and of record fields.

/// The meaning is not the name in other letters.
[[nodiscard]] bool says_more(const EnumValue& value);

/// "0 `regular` (at a constant interval), 1 `forecast` (...)".
[[nodiscard]] std::string values_text(EnumValues values);

/// "0.5 to 0.98"; empty for a choice, whose names are its meaning's.
[[nodiscard]] std::string range_cell(const ParameterInfo& info);

/// A value as a mission file would have it.
[[nodiscard]] std::string value_cell(const ParameterInfo& info, double value);

/// What a parameter or a field means, with its choices or its enumerated values.
[[nodiscard]] std::string meaning_cell(const ParameterInfo& info);
[[nodiscard]] std::string meaning_cell(const FieldInfo& field);

}  // namespace ilp::docgen
