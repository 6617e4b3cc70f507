// The files, folders, sections, functions, programs and tests that the written pages name exist.

#include <fnmatch.h>
#include <gtest/gtest.h>
#include <strings.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "cfg/schedule.hpp"
#include "tests/support/said.hpp"

using ilp::ns_per_ms;
using ilp::schedule;
using ilp::Stage;

namespace {

namespace fs = std::filesystem;

using ilp::test::text_of;

/// Each room of stages has one.
std::vector<fs::path> folder_pages() {
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
  for (const fs::path& page : folder_pages()) files.push_back(page);
  return files;
}

std::vector<std::string> found(const std::string& text, const std::regex& pattern) {
  std::vector<std::string> all;
  for (std::sregex_iterator it(text.begin(), text.end(), pattern), end; it != end; ++it) all.push_back((*it)[1]);
  return all;
}

/// The anchors of a page's headings: lower case, without punctuation, blanks as hyphens.
std::set<std::string> anchors(const std::string& text) {
  static const std::regex heading(R"((?:^|\n)#+ ([^\n]+))");
  std::set<std::string> all;
  for (const std::string& title : found(text, heading)) {
    std::string anchor;
    for (const char c : title) {
      const auto octet = static_cast<unsigned char>(c);
      if (std::isalnum(octet) != 0 || c == '-' || c == '_') anchor += static_cast<char>(std::tolower(octet));
      if (c == ' ') anchor += '-';
    }
    all.insert(anchor);
  }
  return all;
}

TEST(WrittenPages, RelativeLinksLeadSomewhere) {
  static const std::regex link(R"(\]\(([^):]+)\))");
  for (const fs::path& page : pages()) {
    for (const std::string& target : found(text_of(page), link)) {
      const std::size_t mark = target.find('#');
      const fs::path file = mark == 0 ? page : page.parent_path() / target.substr(0, mark);
      ASSERT_TRUE(fs::exists(file)) << page << " links to " << target;
      if (mark == std::string::npos) continue;
      EXPECT_EQ(anchors(text_of(file)).count(target.substr(mark + 1)), 1U) << page << " links to " << target;
    }
  }
}

TEST(WrittenPages, EveryStageHasItsRowInThePageOfItsRoom) {
  for (const Stage& stage : schedule) {
    const std::string row = std::string("| `") + stage.name + "` |";
    for (const fs::path& page : folder_pages()) {
      const bool own = page.parent_path().filename() == stage.page;
      EXPECT_EQ(text_of(page).find(row) != std::string::npos, own) << page << " and the stage " << stage.name;
    }
  }
}

/// In sentences, tables and commands alike.
TEST(WrittenPages, NamedSourceFilesExist) {
  static const std::regex path(
      R"((?:^|[^A-Za-z0-9_./<>-])((?:fsw|hal|bsp|cfg|sim|tests|docs)/[A-Za-z0-9_./-]*[A-Za-z0-9_]))");
  for (const fs::path& page : pages()) {
    for (const std::string& name : found(text_of(page), path)) {
      EXPECT_TRUE(fs::exists(name)) << page << " names " << name;
    }
  }
}

/// The text of all files in the folders of the sources whose names end in one of `endings`.
std::string sources(const std::set<std::string>& endings) {
  std::string text;
  for (const char* const folder : {"fsw", "hal", "bsp", "cfg", "sim", "tests"}) {
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      if (endings.count(entry.path().extension().string()) != 0) text += text_of(entry.path());
    }
  }
  return text;
}

std::set<std::string> words_of(const std::string& text) {
  std::set<std::string> words;
  std::string word;
  for (const char c : text + " ") {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-') {
      word += c;
    } else if (!word.empty()) {
      words.insert(std::move(word));
      word.clear();
    }
  }
  return words;
}

TEST(WrittenPages, NamedMembersExist) {
  static const std::regex member(R"(`(\w+::\w+)(?:\(\))?`)");
  const std::set<std::string> words = words_of(sources({".hpp", ".cpp", ".inc"}));
  for (const fs::path& page : pages()) {
    for (const std::string& name : found(text_of(page), member)) {
      const std::size_t colons = name.find("::");
      EXPECT_EQ(words.count(name.substr(0, colons)) * words.count(name.substr(colons + 2)), 1U)
          << page << " names " << name;
    }
  }
}

TEST(WrittenPages, NamedProgramsAreBuilt) {
  static const std::regex program(R"(build/\w+/bin/([a-z][a-z0-9_-]+)(?![\w-]))");
  const std::set<std::string> words = words_of(sources({".txt", ".cmake"}));
  for (const fs::path& page : pages()) {
    for (const std::string& name : found(text_of(page), program)) {
      EXPECT_EQ(words.count(name), 1U) << page << " names the program " << name;
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
  ASSERT_GT(found(text_of("docs/verification.md"), name).size(), 20U);
  for (const fs::path& page : pages()) {
    for (const std::string& test : found(text_of(page), name)) {
      EXPECT_EQ(tests.count(test), 1U) << page << " names the test " << test;
    }
  }
}

/// Also a program of tests, by its name in CMake, and the instances of a parameterised suite: `Some/Suite.*`.
bool is_shown(const std::string& name, const std::set<std::string>& tests, const std::set<std::string>& programs) {
  const std::string suite = name.substr(name[0] == '*' ? 0 : name.find('/') + 1);
  if (suite.find('*') == std::string::npos) return tests.count(suite) + programs.count(suite) != 0;
  return std::any_of(tests.begin(), tests.end(),
                     [&](const std::string& test) { return fnmatch(suite.c_str(), test.c_str(), 0) == 0; });
}

/// `ILP-MOT-012` in the first cell, tests in the last one, all of which exist. The numbers of a section grow, so none
/// stands twice.
TEST(WrittenPages, EveryRequirementHasANumberAndATest) {
  static const std::regex row(R"(\| ILP-([A-Z]{3})-(\d{3}) \| ([^|]+) \| ([^|]+) \|)");
  static const std::regex name(R"(`([^`]+)`)");
  static const std::regex of_test(R"([\w*]+(/[\w]+)?\.[\w.*]+|test_\w+|store_tls|postgres_memory)");
  const std::set<std::string> tests = tests_in_sources(), programs = words_of(sources({".txt"}));
  std::istringstream page(text_of("docs/verification.md"));
  std::map<std::string, int> latest;
  std::string area;
  bool requirements = false;
  for (std::string line; std::getline(page, line);) {
    if (line.rfind("| number | ", 0) == 0) requirements = true;
    if (line.empty()) requirements = false;
    if (!requirements || line.rfind("| number | ", 0) == 0 || line.rfind("|---", 0) == 0) continue;
    std::smatch cells;
    ASSERT_TRUE(std::regex_match(line, cells, row)) << "three cells are expected, and a number in the first: ILP-"
                                                    << area << "-" << latest[area] + 1 << " is free in " << line;
    const std::string shown_by = cells[4];
    area = cells[1];
    EXPECT_GT(std::stoi(cells[2]), latest[area]) << "ILP-" << area << " has had this number: " << line;
    latest[area] = std::stoi(cells[2]);
    std::size_t shown = 0;
    for (const std::string& test : found(shown_by, name)) {
      if (!std::regex_match(test, of_test)) continue;
      EXPECT_TRUE(is_shown(test, tests, programs)) << line.substr(2, 11) << " names the test " << test;
      ++shown;
    }
    EXPECT_TRUE(shown > 0 || shown_by.find("`static_assert`") == 0) << line.substr(2, 11) << " is shown by nothing";
  }
  EXPECT_GT(latest.size(), 25U);
}

/// In the order of the alphabet, no more than a reader takes in, each with a source.
TEST(WrittenPages, EveryTermOfTheGlossaryHasASource) {
  static const std::regex row(R"(\n\| ([^|]+) \| [^|]+ \| [^|]+(?= \|))");
  std::vector<std::string> terms = found(text_of("docs/glossary.md"), row);
  terms.erase(terms.begin());
  EXPECT_GT(terms.size(), 20U);
  EXPECT_LE(terms.size(), 60U);
  const auto before = [](const std::string& a, const std::string& b) { return strcasecmp(a.c_str(), b.c_str()) < 0; };
  EXPECT_TRUE(std::is_sorted(terms.begin(), terms.end(), before));
}

constexpr std::size_t longest_paragraph = 120;  ///< words

/// The words of each paragraph and of each item of a list, by the line where it begins. Headings, tables and code end
/// one and are none.
std::map<std::size_t, std::size_t> words_of_paragraphs(const std::string& text) {
  std::map<std::size_t, std::size_t> words;
  static const std::regex item(R"( *([-*]|\d+\.) .*)");
  std::istringstream lines(text);
  bool fenced = false, open = false;
  std::size_t number = 0, begin = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const bool fence = line.rfind("```", 0) == 0;
    if (fence) fenced = !fenced;
    const bool indented = line.rfind("    ", 0) == 0 && !open;
    if (fence || fenced || indented || line.empty() || line[0] == '|' || line[0] == '#') {
      open = false;
      continue;
    }
    if (!open || std::regex_match(line, item)) begin = number;
    open = true;
    std::istringstream of_line(line);
    words[begin] += static_cast<std::size_t>(
        std::distance(std::istream_iterator<std::string>(of_line), std::istream_iterator<std::string>()));
  }
  return words;
}

TEST(WrittenPages, ParagraphsAreCountedByItemsAndWithoutTablesAndCode) {
  const std::map<std::size_t, std::size_t> expected = {{3, 5}, {6, 3}, {8, 3}, {17, 1}};
  EXPECT_EQ(words_of_paragraphs("# a b\n\none two\nthree four five\n\n- six seven\n| a b | c |\n1. eight\nnine\n\n"
                                "    code code\n\n```\nx y z\n\n```\nten\n"),
            expected);
}

TEST(WrittenPages, NoParagraphIsLongerThanAReaderTakesIn) {
  for (const fs::path& page : pages()) {
    for (const auto& [line, words] : words_of_paragraphs(text_of(page))) {
      EXPECT_LE(words, longest_paragraph) << page << ":" << line << ": say it shorter, or in two paragraphs";
    }
  }
}

TEST(WrittenPages, TheIndexNamesEveryPage) {
  const std::string index = text_of("docs/README.md");
  for (const fs::path& page : pages()) {
    if (page.filename() == "README.md") continue;
    const std::string link = "](" + (page.parent_path() == "docs" ? "" : "../" + page.parent_path().string() + "/");
    EXPECT_NE(index.find(link + page.filename().string() + ")"), std::string::npos) << page;
  }
}

}  // namespace
