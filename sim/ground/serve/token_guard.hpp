// Reads and checks the token that authorises commands from the page.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "fsw/packets/hmac_sha256.hpp"

namespace ilp::serve {

/// Reads the token from `file`, or from the environment variable ILP_COMMAND_TOKEN if `file` is empty; then it removes
/// the variable. A token has 16 to 256 printable characters without blanks. Throws std::runtime_error with advice if
/// there is no token, the token is not valid, or other users may read the file.
[[nodiscard]] std::string read_token(const std::string& file);

/// Keeps only the HMAC of the token, with a random key. The right token is accepted after any number of wrong ones, so
/// that an attacker cannot lock the operator out; 16 random characters cannot be guessed. May be used by several
/// threads.
class TokenGuard {
 public:
  using Clock = std::chrono::steady_clock;

  explicit TokenGuard(std::string_view token);
  /// Takes the same time for all tokens of one length.
  [[nodiscard]] bool is_right(std::string_view token) const;
  /// Counts a wrong token. Returns their number since the start if the operator is to be informed: at the first, then
  /// at most once in `reported_every`; else none.
  std::optional<std::uint64_t> count_wrong(Clock::time_point now);

  static constexpr std::chrono::seconds reported_every{10};

 private:
  [[nodiscard]] HmacSha256 code_of(std::string_view token) const;

  std::array<std::uint8_t, 32> key_{};
  HmacSha256 code_{};
  std::mutex mutex_;
  std::uint64_t wrong_ = 0;
  Clock::time_point reported_;
};

}  // namespace ilp::serve
