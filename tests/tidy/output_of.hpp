// What a command of the shell prints.
#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace ilp::test {

/// Empty when it cannot be started.
inline std::string output_of(const std::string& command) {
  std::string text;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return text;
  std::array<char, 65536> buffer{};
  for (std::size_t n = 0; (n = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) text.append(buffer.data(), n);
  pclose(pipe);
  return text;
}

}  // namespace ilp::test
