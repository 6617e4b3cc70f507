// Parameters of a scenario by name, with units and ranges, for scenario files, `--set` and campaigns.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "fsw/base/geometry.hpp"

namespace ilp::world {

/// One field of a parameter struct. Range and unit apply to numbers only.
struct Parameter {
  std::string_view name;
  std::variant<double*, int*, std::uint64_t*, bool*, std::string*, Lens*> field;
  std::string_view unit;     ///< empty: none
  std::string_view meaning;  ///< a few words
  double lowest = -std::numeric_limits<double>::max();
  double highest = std::numeric_limits<double>::max();
};

/// The shortest text that reads back as the same number.
[[nodiscard]] std::string number_text(double value);
/// " from LOWEST to HIGHEST UNIT", without the parts that the parameter does not have.
[[nodiscard]] std::string range_text(const Parameter& parameter);

/// Sets a field from text. An angle in rad may be given in degrees: 90deg. Throws std::invalid_argument that names the
/// section, the parameter, the text and what was expected; for an unknown name it lists the parameters of the section.
void set_parameter(const std::vector<Parameter>& parameters, std::string_view section, std::string_view name,
                   std::string_view text);

/// The current value of the field, as text for set_parameter.
[[nodiscard]] std::string parameter_text(const Parameter& parameter);

/// Throws std::invalid_argument for the first number that is outside its range or not finite.
void check_parameters(const std::vector<Parameter>& parameters, std::string_view section);

}  // namespace ilp::world
