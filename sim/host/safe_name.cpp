#include "sim/host/safe_name.hpp"

#include <algorithm>
#include <cstdint>

namespace ilp::host {

std::string safe_name(std::string_view name) {
  const std::size_t slash = name.find_last_of("/\\");
  if (slash != std::string_view::npos) name.remove_prefix(slash + 1);
  constexpr std::string_view kept = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-+@";
  std::string safe;
  for (const char c : name.substr(0, 128)) safe += kept.find(c) == std::string_view::npos ? '_' : c;
  const bool only_dots = std::all_of(safe.begin(), safe.end(), [](char c) { return c == '.'; });
  return only_dots ? std::string() : safe;
}

std::string stem(std::string_view name) {
  const std::size_t dot = name.rfind('.');
  return std::string(dot == std::string_view::npos || dot == 0 ? name : name.substr(0, dot));
}

std::string six_digits(std::int64_t number) {
  std::string digits = std::to_string(number);
  if (digits.size() < 6) digits.insert(0, 6 - digits.size(), '0');
  return digits;
}

}  // namespace ilp::host
