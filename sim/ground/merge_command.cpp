#include "sim/ground/merge_command.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <string>
#include <system_error>
#include <vector>

namespace ilp::ground {
namespace fs = std::filesystem;

int merge_main(int argc, char** argv) {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error), folder = program.parent_path();
  fs::path script = folder / "merge.py";
  if (!fs::exists(script)) script = (folder / "../../../sim/tools/cluster/merge.py").lexically_normal();
  if (!fs::exists(script)) {
    std::cerr << "ilp-ground merge: there is neither " << (folder / "merge.py").string() << " nor " << script.string()
              << "\n";
    return 2;
  }
  std::vector<std::string> words{"python3", "-B", script.string(), "--ground", program.string()};
  words.insert(words.end(), argv + 2, argv + argc);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  ::execvp(arguments[0], arguments.data());
  std::cerr << "ilp-ground merge: python3 cannot be started: " << std::strerror(errno) << "\n";
  return 2;
}

}  // namespace ilp::ground
