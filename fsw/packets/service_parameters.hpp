// ST[20] parameter management: lists of parameters, and values of the types of the field tables.
#pragma once

#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/packets/tailoring.hpp"
#include "fsw/records/field.hpp"

namespace ilp {

namespace parameter_management {
inline constexpr std::uint8_t service = 20;
inline constexpr std::uint8_t report = 1, values = 2, set = 3;
}  // namespace parameter_management

using ParameterList = FixedVector<std::uint32_t, limits::max_list_items>;

/// TC[20,1]: `request_malformed` (a = offset), `capacity_exceeded`.
Status decode_parameter_list(const Tailoring& tailoring, std::span<const std::uint8_t> data, ParameterList& list);

/// Reads a number of a type with one element, big-endian: u8 to f64.
[[nodiscard]] double read_value(FieldType type, ByteReader& in);
/// Whole numbers are rounded to the nearest and limited to their type.
void write_value(FieldType type, double value, ByteWriter& out);

}  // namespace ilp
