#include "fsw/packets/hmac_sha256.hpp"

#include <sodium/crypto_auth_hmacsha256.h>
#include <sodium/utils.h>

namespace ilp {

static_assert(crypto_auth_hmacsha256_BYTES == sizeof(HmacSha256));

HmacSha256 hmac_sha256(std::span<const std::uint8_t> key, std::span<const std::span<const std::uint8_t>> parts) {
  crypto_auth_hmacsha256_state state;
  HmacSha256 code{};
  // These three cannot fail.
  crypto_auth_hmacsha256_init(&state, key.data(), key.size());
  for (const std::span<const std::uint8_t> part : parts) {
    crypto_auth_hmacsha256_update(&state, part.data(), part.size());
  }
  crypto_auth_hmacsha256_final(&state, code.data());
  return code;
}

bool equal_in_constant_time(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b) {
  return a.size() == b.size() && sodium_memcmp(a.data(), b.data(), a.size()) == 0;
}

}  // namespace ilp
