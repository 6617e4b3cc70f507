// The token that the panel of commands asks for.
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

/// Reads the token from `file`, or from the environment variable ILP_COMMAND_TOKEN if `file` is empty; the variable is
/// then removed. 16 to 256 printable characters without blanks. Throws std::runtime_error with advice if there is none,
/// if it is too short, or if others may read the file.
[[nodiscard]] std::string read_token(const std::string& file);

/// Keeps no token, only its code under a key drawn at the start. The right token is right at any time, however many
/// wrong ones come: who guesses must not shut the operator out. A token of 16 random characters is not guessed. May be
/// used by several threads.
class TokenGuard {
 public:
  using Clock = std::chrono::steady_clock;

  explicit TokenGuard(std::string_view token);
  /// Takes the same time for any token of a length.
  [[nodiscard]] bool is_right(std::string_view token) const;
  /// How many wrong tokens have come since the start, where the operator is to be told: at the first, then at most once
  /// in `reported_every`.
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
