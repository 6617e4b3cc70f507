// A Status in words, for the programs of the board and of the ground.
#pragma once

#include <cstdint>

#include "fsw/base/enumeration.hpp"
#include "fsw/base/status_values.hpp"
#include "fsw/base/text.hpp"

namespace ilp {

using StatusText = FixedText<512>;

/// The named values of a type that is an enumeration; otherwise empty.
[[nodiscard]] EnumValues named_values(ValueType type);

/// A value with its unit, or by its name. A number that has no name is written as it is.
[[nodiscard]] StatusText value_text(ValueType type, std::int64_t value);

/// The text of the status with its values.
[[nodiscard]] StatusText status_words(const Status& status);

}  // namespace ilp
