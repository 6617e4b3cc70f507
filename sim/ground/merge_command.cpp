#include "sim/ground/merge_command.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <string>
#include <system_error>
#include <vector>

namespace ilp::ground {
namespace fs = std::filesystem;
namespace {

/// Where the script may lie, in the order of search, for a program in `folder`: beside it, where packages install it
/// (bsp/packages/packages.cmake), and in the sources when the program is in their build folder.
std::array<fs::path, 3> places_of_script(const fs::path& folder) {
  const fs::path script = "sim/tools/cluster/merge.py";
  return {folder / "merge.py", (folder / "../share/aerobot-ilp-ground" / script).lexically_normal(),
          (folder / "../../.." / script).lexically_normal()};
}

}  // namespace

int merge_main(int argc, char** argv) {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const auto places = places_of_script(program.parent_path());
  const auto script = std::find_if(places.begin(), places.end(),
                                   [&](const fs::path& place) { return fs::is_regular_file(place, error); });
  if (script == places.end()) {
    std::cerr << "ilp-ground merge: the script that runs tasks is in none of these places: " << places[0].string()
              << ", " << places[1].string() << ", " << places[2].string()
              << ". Install the package aerobot-ilp-ground again\n";
    return 2;
  }
  std::vector<std::string> words{"python3", "-B", script->string(), "--ground", program.string()};
  words.insert(words.end(), argv + 2, argv + argc);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  ::execvp(arguments[0], arguments.data());
  std::cerr << "ilp-ground merge: python3 cannot be started: " << std::strerror(errno) << "\n";
  return 2;
}

}  // namespace ilp::ground
