#include "sim/ground/serve/token_guard.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <random>
#include <span>
#include <stdexcept>

#include "hal/posix/private_file.hpp"

namespace ilp::serve {
namespace {

constexpr std::size_t shortest_token = 16, longest_token = 256;
constexpr const char* variable = "ILP_COMMAND_TOKEN";
constexpr const char* how_to_make_one = "make one with: (umask 077; head -c 24 /dev/urandom | base64 >token)";

std::string token_of_file(const std::string& path) {
  std::array<std::uint8_t, longest_token + 3> text{};
  std::size_t bytes = 0;
  const Status status = read_private_file(path.c_str(), text, bytes);
  if (status.is(StatusCode::file_not_private)) {
    throw std::runtime_error("others may read the token file " + path + ": run chmod 600 " + path);
  }
  if (status.is(StatusCode::io_error) && status.a == EINVAL) {
    throw std::runtime_error("the token file " + path + " is no plain file; " + how_to_make_one);
  }
  if (!status.ok()) {
    const int error = status.is(StatusCode::not_found) ? ENOENT : static_cast<int>(status.a);
    throw std::runtime_error("cannot read the token file " + path + ": " + std::strerror(error) + "; " +
                             how_to_make_one);
  }
  const std::string_view content(reinterpret_cast<const char*>(text.data()), bytes);
  return std::string(content.substr(0, content.find('\n')));
}

std::string token_of_environment() {
  const char* value = std::getenv(variable);
  if (value == nullptr) {
    throw std::runtime_error(std::string("commands need a token, in a file (--token-file FILE) or in the variable ") +
                             variable + "; " + how_to_make_one);
  }
  std::string token = value;
  (void)::unsetenv(variable);
  return token;
}

}  // namespace

std::string read_token(const std::string& file) {
  const std::string token = file.empty() ? token_of_environment() : token_of_file(file);
  const bool printable = std::all_of(token.begin(), token.end(), [](char c) { return c > ' ' && c <= '~'; });
  if (token.size() < shortest_token || token.size() > longest_token || !printable) {
    throw std::runtime_error("the token in " + (file.empty() ? std::string(variable) : file) +
                             " must have 16 to 256 printable characters without blanks; " + how_to_make_one);
  }
  return token;
}

TokenGuard::TokenGuard(std::string_view token) {
  std::random_device random;
  for (std::uint8_t& octet : key_) octet = static_cast<std::uint8_t>(random());
  code_ = code_of(token);
}

// Codes have one length, so that their comparison tells nothing about the token's.
HmacSha256 TokenGuard::code_of(std::string_view token) const {
  const std::span<const std::uint8_t> part(reinterpret_cast<const std::uint8_t*>(token.data()), token.size());
  return hmac_sha256(key_, std::span(&part, 1));
}

bool TokenGuard::is_right(std::string_view token) const {
  return equal_in_constant_time(code_of(token), code_);
}

std::optional<std::uint64_t> TokenGuard::count_wrong(Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  if (++wrong_ > 1 && now - reported_ < reported_every) return std::nullopt;
  reported_ = now;
  return wrong_;
}

}  // namespace ilp::serve
