// Writes a Status and its values as text, for the programs of the board and of the ground.
#pragma once

#include <cstdint>

#include "fsw/base/enumeration.hpp"
#include "fsw/base/status_values.hpp"
#include "fsw/base/text.hpp"

namespace ilp {

using StatusText = FixedText<512>;

/// Returns the named values of an enumeration; empty for other types.
[[nodiscard]] EnumValues named_values(ValueType type);

/// Returns a value as text: its name if it has one, else the number with its unit.
[[nodiscard]] StatusText value_text(ValueType type, std::int64_t value);

/// Returns the text of the status with its values in it.
[[nodiscard]] StatusText status_words(const Status& status);

}  // namespace ilp
