// Reads octets written by independent implementations from the data folder (../shared/data/tctm), if it exists.
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

/// Returns the octets in the last word of each line, with the line's first word as key. Lines that begin with # are
/// skipped. Empty if there is no such file.
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
