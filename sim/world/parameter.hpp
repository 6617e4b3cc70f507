// A scenario's parameters by name: what files, `--set` and campaigns change, with units and ranges.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "fsw/base/geometry.hpp"

namespace ilp::world {

/// One field of a parameter struct. Range and unit count for numbers only.
struct Parameter {
  std::string_view name;
  std::variant<double*, int*, std::uint64_t*, bool*, std::string*, Lens*> field;
  std::string_view unit;     ///< empty: none
  std::string_view meaning;  ///< a few words
  double lowest = -std::numeric_limits<double>::max();
  double highest = std::numeric_limits<double>::max();
};

/// The shortest text that reads as the same number.
[[nodiscard]] std::string number_text(double value);
/// " from LOWEST to HIGHEST UNIT", without what there is not.
[[nodiscard]] std::string range_text(const Parameter& parameter);

/// Sets a field from text. std::invalid_argument names the section, the parameter, the text and what was expected: a
/// number in its range, a whole number, true or false, or one of the section's parameters.
void set_parameter(const std::vector<Parameter>& parameters, std::string_view section, std::string_view name,
                   std::string_view text);

/// The text that sets the field to the value it has.
[[nodiscard]] std::string parameter_text(const Parameter& parameter);

/// std::invalid_argument for the first number outside its range, or not finite.
void check_parameters(const std::vector<Parameter>& parameters, std::string_view section);

}  // namespace ilp::world
