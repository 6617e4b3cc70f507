#include "bsp/flight/key_file.hpp"

#include <array>

#include "hal/posix/private_file.hpp"

namespace ilp {

Status read_key_file(const char* path, Authenticator& authenticator) {
  std::array<std::uint8_t, 4096> text{};
  std::size_t size = 0;
  ILP_TRY(read_private_file(path, text, size));
  if (size == text.size()) {
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(size), static_cast<std::int64_t>(text.size()) - 1};
  }
  return authenticator.add_keys({reinterpret_cast<const char*>(text.data()), size});
}

}  // namespace ilp
