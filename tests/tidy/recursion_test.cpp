// No function of the flight reaches itself by direct calls: read from the relocations of the flight libraries, in which
// each function is a section of its own. Calls through pointers and tables of virtual functions are not seen.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/tidy/output_of.hpp"

namespace {

namespace fs = std::filesystem;

using Calls = std::map<std::string, std::set<std::string>>;

/// The function of a section or symbol. What the compiler has moved away as unlikely is a part of it.
std::string function_of(const std::string& name) {
  static const std::regex prefix(R"(^\.text\.((unlikely|hot|startup|exit)\.)?)"), suffix(R"(\.cold$)");
  return std::regex_replace(std::regex_replace(name, prefix, ""), suffix, "");
}

void add_calls(const fs::path& library, Calls& calls) {
  static const std::regex section(R"(^Relocation section '\.rela(\.text\S*)')");
  static const std::regex relocation(R"(^[0-9a-f]+\s+[0-9a-f]+\s+(R_\S+)\s+[0-9a-f]+\s+(\S+))");
  static const std::set<std::string> branches = {"R_X86_64_PLT32", "R_AARCH64_CALL26", "R_AARCH64_JUMP26"};
  std::istringstream in(
      ilp::test::output_of(std::string(ILP_READELF) + " --wide --relocs '" + library.string() + "' 2>/dev/null"));
  std::string caller;
  std::smatch match;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("Relocation section")) {
      caller = std::regex_search(line, match, section) ? match[1].str() : "";
    } else if (!caller.empty() && std::regex_search(line, match, relocation)) {
      const std::string kind = match[1], callee = match[2];
      // Functions of the same source are named by their sections.
      if (branches.count(kind) == 0 && !callee.starts_with(".text.")) continue;
      const std::string from = function_of(caller), to = function_of(callee);
      // From the unlikely part back, and within a table of branches, is no call.
      if (from != to || caller == ".text." + callee) calls[from].insert(to);
    }
  }
}

/// Removes what calls nothing that is left, until only cycles and what reaches them are left.
void keep_cycles(Calls& calls) {
  for (std::size_t before = calls.size() + 1; calls.size() < before;) {
    before = calls.size();
    for (auto& [caller, callees] : calls) {
      std::erase_if(callees, [&](const std::string& callee) { return calls.count(callee) == 0; });
    }
    std::erase_if(calls, [](const auto& entry) { return entry.second.empty(); });
  }
}

Calls reversed(const Calls& calls) {
  Calls callers;
  for (const auto& [caller, callees] : calls) {
    for (const std::string& callee : callees) callers[callee].insert(caller);
  }
  return callers;
}

class Recursion : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Builds, Recursion, testing::Values("host", "aarch64"),
                         [](const auto& test) { return std::string(test.param); });

TEST_P(Recursion, NoFunctionOfTheFlightReachesItselfByCalls) {
  const bool host = std::string(GetParam()) == "host";
  const fs::path build = host ? fs::path(ILP_BUILD_DIR) : fs::path(ILP_SOURCE_DIR) / "build" / "aarch64";
  std::ifstream list(build / "flight-libraries.txt");
  Calls calls;
  for (std::string library; std::getline(list, library);) {
    if (!library.empty() && fs::exists(library)) add_calls(library, calls);
  }
  if (!host && calls.empty()) GTEST_SKIP() << "cmake --preset aarch64 && cmake --build --preset aarch64";
  EXPECT_GT(calls.size(), 1000U);
  keep_cycles(calls);
  calls = reversed(calls);
  keep_cycles(calls);
  std::string names;
  for (const auto& [function, callers] : calls) names += function + "\n";
  EXPECT_EQ(names, "") << "these functions reach themselves, or lie between two that do";
}

}  // namespace
