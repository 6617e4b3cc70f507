// ST[08] function management and ST[17] test.
#pragma once

#include <cstdint>
#include <span>

#include "fsw/packets/tailoring.hpp"

namespace ilp {

namespace function_management {
inline constexpr std::uint8_t service = 8, perform = 1;
}
namespace test_service {
inline constexpr std::uint8_t service = 17;
inline constexpr std::uint8_t are_you_alive = 1, alive = 2, connection_test = 3, connected = 4;
}  // namespace test_service

inline constexpr std::size_t function_name_bytes = 8;

struct FunctionCall {
  char name[function_name_bytes + 1] = {};  ///< terminated
  std::span<const std::uint8_t> arguments;
};

/// TC[8,1]. `request_malformed` for less than a name, or a name with octets after its first zero.
Status decode_function(std::span<const std::uint8_t> data, FunctionCall& call);
void encode_function(const FunctionCall& call, ByteWriter& out);

/// TC[17,3] and TM[17,4], which have the same content. `request_malformed`.
Status decode_connection(std::span<const std::uint8_t> data, std::uint16_t& application);

}  // namespace ilp
