// Serialises application data of telecommands.
#pragma once

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "fsw/packets/bytes.hpp"
#include "fsw/packets/service_functions.hpp"

namespace ilp::console {

/// The octets that `fill` writes into a ByteWriter.
template <typename Fill>
[[nodiscard]] std::vector<std::uint8_t> data_of(const Fill& fill) {
  std::vector<std::uint8_t> bytes(65536);
  ByteWriter writer(bytes);
  fill(writer);
  if (!writer.ok()) throw std::logic_error("the data of a telecommand do not fit");
  bytes.resize(writer.size());
  return bytes;
}

/// Data of TC[8,1]. The name is truncated to 8 characters.
[[nodiscard]] inline std::vector<std::uint8_t> function(std::string_view name,
                                                        const std::vector<std::uint8_t>& arguments = {}) {
  FunctionCall call;
  std::copy_n(name.data(), std::min(name.size(), function_name_bytes), call.name);
  call.arguments = arguments;
  return data_of([&](ByteWriter& out) { encode_function(call, out); });
}

}  // namespace ilp::console
