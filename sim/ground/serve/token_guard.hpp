// The token that the page of commands asks for, and how often a client may be wrong about it.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>

#include "fsw/packets/hmac_sha256.hpp"

namespace ilp::serve {

/// Reads the token from `file`, or from the environment variable ILP_COMMAND_TOKEN if `file` is empty; the variable is
/// then removed. 16 to 256 printable characters without blanks. Throws std::runtime_error with advice if there is none,
/// if it is too short, or if others may read the file.
[[nodiscard]] std::string read_token(const std::string& file);

/// Keeps no token, only its code under a key drawn at the start. A client may be wrong `free_tries` times; after each
/// further wrong token it is not heard for 1, 2, 4, ... at most 60 s, whatever it sends. After two minutes without a
/// wrong token its count begins again; a right token does not clear it, because the operator's page shows one every few
/// seconds. At most `clients` addresses are remembered; the one that was wrong longest ago is forgotten first. May be
/// used by several threads.
class TokenGuard {
 public:
  using Clock = std::chrono::steady_clock;
  enum class Verdict : std::uint8_t { right, wrong, wait };

  explicit TokenGuard(std::string_view token);
  Verdict check(std::string_view token, std::uint32_t client, Clock::time_point now);
  /// Wrong tokens of all clients since the start, those while a client was not heard too.
  [[nodiscard]] std::uint64_t wrong() const;
  /// Until the client is heard again, rounded up.
  [[nodiscard]] int wait_s(std::uint32_t client, Clock::time_point now) const;

  static constexpr unsigned free_tries = 5;

 private:
  static constexpr std::size_t clients = 64;
  static constexpr int longest_wait_s = 60;
  static constexpr std::chrono::minutes memory{2};
  struct Client {
    std::uint32_t address = 0;
    unsigned wrong = 0;
    Clock::time_point latest, until;
  };
  [[nodiscard]] HmacSha256 code_of(std::string_view token) const;
  [[nodiscard]] Client* find(std::uint32_t address);
  void count_wrong(std::uint32_t address, Clock::time_point now);

  std::array<std::uint8_t, 32> key_{};
  HmacSha256 code_{};
  mutable std::mutex mutex_;
  std::array<Client, clients> clients_{};
  std::uint64_t wrong_ = 0;
};

}  // namespace ilp::serve
