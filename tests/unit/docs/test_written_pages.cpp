// What the written pages name exists: files, folders, tests.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "cfg/schedule.hpp"

using ilp::ns_per_ms;
using ilp::schedule;
using ilp::Stage;

namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// Each room of stages has one.
std::vector<fs::path> room_pages() {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator("fsw")) {
    if (fs::exists(entry.path() / "design.md")) files.push_back(entry.path() / "design.md");
  }
  return files;
}

std::vector<fs::path> pages() {
  std::vector<fs::path> files = {"README.md"};
  for (const auto& entry : fs::directory_iterator("docs")) {
    if (entry.path().extension() == ".md") files.push_back(entry.path());
  }
  for (const fs::path& page : room_pages()) files.push_back(page);
  return files;
}

std::vector<std::string> found(const std::string& text, const std::regex& pattern) {
  std::vector<std::string> all;
  for (std::sregex_iterator it(text.begin(), text.end(), pattern), end; it != end; ++it) all.push_back((*it)[1]);
  return all;
}

TEST(WrittenPages, RelativeLinksLeadSomewhere) {
  static const std::regex link(R"(\]\(([^)#:]+)(#[^)]*)?\))");
  for (const fs::path& page : pages()) {
    for (const std::string& target : found(text_of(page), link)) {
      EXPECT_TRUE(fs::exists(page.parent_path() / target)) << page << " links to " << target;
    }
  }
}

TEST(WrittenPages, EveryStageHasItsRowInThePageOfItsRoom) {
  for (const Stage& stage : schedule) {
    const std::string row = std::string("| `") + stage.name + "` |";
    for (const fs::path& page : room_pages()) {
      const bool own = page.parent_path().filename() == stage.page;
      EXPECT_EQ(text_of(page).find(row) != std::string::npos, own) << page << " and the stage " << stage.name;
    }
  }
}

TEST(WrittenPages, NamedSourceFilesExist) {
  static const std::regex path(R"(`((fsw|hal|bsp|cfg|sim|tests|docs)/[A-Za-z0-9_./-]+)`)");
  for (const fs::path& page : pages()) {
    for (const std::string& name : found(text_of(page), path)) {
      EXPECT_TRUE(fs::exists(name)) << page << " names " << name;
    }
  }
}

/// Suite.Name of every test in the sources, and tests that CMake adds by name. Instances of a parameterised suite go by
/// the suite's name.
std::set<std::string> tests_in_sources() {
  static const std::regex macro(R"(\b(?:TYPED_)?TEST(?:_F|_P)?\(\s*(\w+)\s*,\s*(\w+)\s*\))");
  std::set<std::string> names;
  static const std::regex added(R"(\badd_test\(NAME\s+([\w.]+))");
  static const std::regex on_board(R"(\bilp_board_test\((\w+))");
  static const std::regex campaign(R"(\bilp_campaign\(([A-Z]\w+))");
  for (const auto& entry : fs::recursive_directory_iterator("tests")) {
    const bool listing = entry.path().filename() == "CMakeLists.txt";
    if (entry.path().extension() != ".cpp" && !listing) continue;
    const std::string text = text_of(entry.path());
    for (const std::string& name : found(text, added)) names.insert(name);
    for (const std::string& name : found(text, on_board)) names.insert("Board." + name);
    for (const std::string& name : found(text, campaign)) {
      names.insert({"Faults." + name, "LongFaults." + name, "LongFaults.*"});
    }
    for (std::sregex_iterator it(text.begin(), text.end(), macro), end; it != end; ++it) {
      names.insert((*it)[1].str() + "." + (*it)[2].str());
      names.insert((*it)[1].str() + ".*");
    }
  }
  return names;
}

TEST(WrittenPages, NamedTestsExist) {
  static const std::regex name(R"(`([A-Z]\w+\.([A-Z]\w+|\*))`)");
  const std::set<std::string> tests = tests_in_sources();
  ASSERT_GT(tests.size(), 100U);
  const std::vector<std::string> named = found(text_of("docs/verification.md"), name);
  ASSERT_GT(named.size(), 20U);
  for (const std::string& test : named) {
    EXPECT_EQ(tests.count(test), 1U) << "docs/verification.md names the test " << test;
  }
}

}  // namespace
