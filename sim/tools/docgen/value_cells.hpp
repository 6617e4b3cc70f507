// Cells of tables that state the values of parameters and of record fields.
#pragma once

#include <string>

#include "cfg/mission.hpp"

namespace ilp::docgen {

/// "0 `regular` (at a constant interval), 1 `forecast` (...)".
[[nodiscard]] std::string values_text(EnumValues values);

/// "0.5 to 0.98", or the names of a choice: "`false`, `true`".
[[nodiscard]] std::string range_cell(const ParameterInfo& info);

/// A value as a mission file would have it.
[[nodiscard]] std::string value_cell(const ParameterInfo& info, double value);

/// What a parameter or a field means, with its choices or its enumerated values.
[[nodiscard]] std::string meaning_cell(const ParameterInfo& info);
[[nodiscard]] std::string meaning_cell(const FieldInfo& field);

}  // namespace ilp::docgen
