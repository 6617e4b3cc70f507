#include "fsw/packets/service_functions.hpp"

namespace ilp {

Status decode_function(std::span<const std::uint8_t> data, FunctionCall& call) {
  call = {};
  ByteReader in(data);
  const std::span<const std::uint8_t> name = in.take(function_name_bytes);
  if (!in.ok()) return {StatusCode::request_malformed, static_cast<std::int64_t>(data.size())};
  bool ended = false;
  for (std::size_t i = 0; i < name.size(); ++i) {
    if (ended && name[i] != 0) return {StatusCode::request_malformed, static_cast<std::int64_t>(i)};
    ended = name[i] == 0;
    call.name[i] = static_cast<char>(name[i]);
  }
  call.arguments = in.rest();
  return {};
}

void encode_function(const FunctionCall& call, ByteWriter& out) {
  for (std::size_t i = 0; i < function_name_bytes; ++i) out.u8(static_cast<std::uint8_t>(call.name[i]));
  out.put(call.arguments);
}

Status decode_connection(std::span<const std::uint8_t> data, std::uint16_t& application) {
  ByteReader in(data);
  application = in.u16();
  if (!in.ok() || in.left() != 0) return {StatusCode::request_malformed, static_cast<std::int64_t>(in.offset())};
  return {};
}

}  // namespace ilp
