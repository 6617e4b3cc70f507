// Run-time parameters of a mission, which a mission file or a telecommand may change. cfg/parameters.inc has one row
// for each of them.
#pragma once

#include <cstddef>
#include <cstdint>

#include "cfg/choices.hpp"
#include "cfg/limits.hpp"
#include "fsw/base/status.hpp"
#include "fsw/records/field.hpp"

namespace ilp {

/// All parameters with their defaults.
struct MissionParameters {
  using f64 = double;
  using u8 = std::uint8_t;
  using u16 = std::uint16_t;
  using u32 = std::uint32_t;
  using rounded_u32 = double;

#define QUANTITY(number, section, key, type, unit, minimum, maximum, value, acts, meaning) type key = value;
#define CHOICE(number, section, key, enumeration, value, acts, meaning) enumeration key = enumeration::value;
#define FLAG(number, section, key, value, acts, meaning) bool key = value;
#include "cfg/parameters.inc"
#undef QUANTITY
#undef CHOICE
#undef FLAG
};

/// When a value that is set in flight takes effect: at once, or at the next start of the flight software.
enum class Acts : std::uint8_t { at_once, next_start };

/// A row of cfg/parameters.inc.
struct ParameterInfo {
  std::uint16_t number;  ///< permanent: used on the link and in stored settings; from 1
  const char* section;
  const char* key;
  std::uint16_t offset;  ///< bytes into MissionParameters
  FieldType stored;      ///< type in MissionParameters; u8 for a flag or a choice
  FieldType type;        ///< type on the link
  const char* unit;
  double minimum, maximum;
  EnumValues choices;  ///< values of a flag or a choice; empty for other parameters
  Acts acts;
  const char* description;
};

[[nodiscard]] std::size_t parameter_count();
[[nodiscard]] const ParameterInfo& parameter_info(std::size_t index);
/// The index of a parameter with this name or number; parameter_count() if there is none.
[[nodiscard]] std::size_t find_parameter(const char* section, const char* key);
[[nodiscard]] std::size_t find_parameter(std::uint64_t number);

/// The value of a parameter as a number: the number of a choice, 0 or 1 for a flag.
[[nodiscard]] double parameter_value(const MissionParameters& mission, std::size_t index);

/// Sets a parameter. Returns `not_found` for an unknown name, and `parameter_out_of_range` for a value that is out of
/// range or NaN, or that has a fraction although the parameter is an integer, a choice or a flag.
Status set_parameter(MissionParameters& mission, const char* section, const char* key, double value);
Status set_parameter(MissionParameters& mission, std::size_t index, double value);
/// Checks the relations between parameters. Returns `parameters_contradict` with the first Relation that does not hold.
Status validate(const MissionParameters& mission);

/// Number of keyframes in an adjustment window: ceil(1 / (1 - target overlap)) (decisions.md, 5), unless the mission
/// sets a length.
[[nodiscard]] std::uint32_t window_length(const MissionParameters& mission);

}  // namespace ilp
