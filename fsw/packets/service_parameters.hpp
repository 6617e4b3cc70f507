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

/// Decodes TC[20,1]. Returns `request_malformed` (first value: offset in `data`) if the list is cut, is empty or is
/// followed by further octets, and `capacity_exceeded` if it is too long.
Status decode_parameter_list(const Tailoring& tailoring, std::span<const std::uint8_t> data, ParameterList& list);

/// Reads one big-endian number of `type`.
[[nodiscard]] double read_value(FieldType type, ByteReader& in);
/// Appends one big-endian number of `type`: u8, u16, u32, f32 or f64. Integers are rounded to the nearest and clamped
/// to the range of the type.
void write_value(FieldType type, double value, ByteWriter& out);

}  // namespace ilp
