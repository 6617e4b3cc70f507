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

/// Decodes TC[8,1]. Returns `request_malformed` if the name is cut short or has an octet other than 0 after a zero.
Status decode_function(std::span<const std::uint8_t> data, FunctionCall& call);
void encode_function(const FunctionCall& call, ByteWriter& out);

/// Decodes TC[17,3] or TM[17,4], which have the same content: an APID. Returns `request_malformed` if the data are no
/// two octets.
Status decode_connection(std::span<const std::uint8_t> data, std::uint16_t& application);

}  // namespace ilp
