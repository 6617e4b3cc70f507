// Octets that independent implementations wrote, where the data folder is there (../shared/data/tctm).
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include "tests/support/hex.hpp"

namespace ilp {

inline std::filesystem::path golden_folder() {
  return std::filesystem::path(ILP_SOURCE_DIR) / "../shared/data/tctm";
}

/// The last word of every line that is no comment, by the line's first word; empty when there is no such file.
inline std::map<std::string, Bytes> golden_vectors(const char* file) {
  std::map<std::string, Bytes> vectors;
  std::ifstream in(golden_folder() / file);
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    std::string name, hex;
    words >> name;
    while (words >> hex) continue;
    vectors[name] = from_hex(hex);
  }
  return vectors;
}

}  // namespace ilp
