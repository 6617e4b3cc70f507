// A folder of its own for each test, and what tests do with files in it.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/said.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp::test {

class ScratchFolder : public TemporaryFolder {
 public:
  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const { return path() / name; }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(path() / name, std::ios::binary) << text;
    return path() / name;
  }
};

}  // namespace ilp::test
