#include "fsw/packets/service_parameters.hpp"

#include <algorithm>

namespace ilp {
namespace {

std::uint64_t whole(double value, double most) {
  return static_cast<std::uint64_t>(std::clamp(value + 0.5, 0.0, most));
}

}  // namespace

Status decode_parameter_list(const Tailoring& tailoring, std::span<const std::uint8_t> data, ParameterList& list) {
  ByteReader in(data);
  list.clear();
  const auto malformed = [&] { return Status{StatusCode::request_malformed, static_cast<std::int64_t>(in.offset())}; };
  const std::uint32_t count = read_count(tailoring.parameter_count, in);
  if (!in.ok() || count == 0) return malformed();
  if (count > limits::max_list_items) {
    return {StatusCode::capacity_exceeded, count, static_cast<std::int64_t>(limits::max_list_items)};
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto id = static_cast<std::uint32_t>(in.number(tailoring.parameter_id));
    if (!in.ok()) return malformed();
    static_cast<void>(list.push_back(id));
  }
  return in.left() == 0 ? Status{} : malformed();
}

double read_value(FieldType type, ByteReader& in) {
  switch (type) {
    case FieldType::f32:
      return static_cast<double>(in.f32());
    case FieldType::f64:
      return in.f64();
    case FieldType::i32:
      return static_cast<double>(in.i32());
    case FieldType::i64:
      return static_cast<double>(static_cast<std::int64_t>(in.number(8)));
    case FieldType::u8:
    case FieldType::u16:
    case FieldType::u32:
    case FieldType::text:
    case FieldType::blob:
      break;
  }
  return static_cast<double>(in.number(element_bytes(type)));
}

void write_value(FieldType type, double value, ByteWriter& out) {
  switch (type) {
    case FieldType::u8:
      return out.number(whole(value, 255.0), 1);
    case FieldType::u16:
      return out.number(whole(value, 65535.0), 2);
    case FieldType::f32:
      return out.f32(static_cast<float>(value));
    case FieldType::f64:
      return out.f64(value);
    case FieldType::u32:
    case FieldType::i32:
    case FieldType::i64:
    case FieldType::text:
    case FieldType::blob:
      break;
  }
  return out.number(whole(value, 4294967295.0), 4);
}

}  // namespace ilp
