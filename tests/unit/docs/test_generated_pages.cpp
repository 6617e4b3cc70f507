// The pages that follow from tables in the code say what the tables say.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>

#include "bsp/flight/status_text.hpp"
#include "fsw/base/status.hpp"
#include "fsw/packets/report_table.hpp"
#include "sim/tools/docgen/documents.hpp"
#include "sim/tools/docgen/figures.hpp"
#include "tests/support/said.hpp"

namespace {

namespace fs = std::filesystem;

std::string page(const std::string& name) {
  return ilp::test::text_of("docs/" + name);
}

/// Octets of a report as ground software would count them that has the page only: of all items of the section in which
/// a type with numbers follows the field. "`centre_m` f64[3] m" takes 24 octets.
std::size_t octets_by_the_page(const std::string& text, const std::string& heading) {
  const std::map<std::string, std::size_t> widths = {{"u8", 1},  {"u16", 2}, {"u32", 4}, {"i32", 4},
                                                     {"i64", 8}, {"f32", 4}, {"f64", 8}};
  const std::size_t begin = text.find("\n" + heading + "\n");
  if (begin == std::string::npos) return 0;
  std::istringstream section(text.substr(begin + 1, text.find("\n#", begin + 1) - begin));
  std::size_t octets = 0;
  for (std::string line; std::getline(section, line);) {
    const std::size_t field = line.find("` ");
    if (line.rfind("- ", 0) != 0 || field == std::string::npos) continue;
    const std::string type = line.substr(field + 2, line.find_first_of(" :", field + 2) - field - 2);
    const std::size_t bracket = type.find('[');
    const auto width = widths.find(type.substr(0, bracket));
    if (width == widths.end()) continue;
    octets += width->second * (bracket == std::string::npos ? 1 : std::stoul(type.substr(bracket + 1)));
  }
  return octets;
}

TEST(GeneratedPages, TheLayoutOfEveryReportFollowsFromThePages) {
  const std::string interface = page("interface-control-document.md"), records = page("records.md");
  for (const ilp::ReportInfo& report : ilp::report_table()) {
    const std::string sid = std::to_string(report.id), name = report.name;
    const std::size_t octets = ilp::report_bytes(report);
    const bool of_record = report.record != ilp::RecordType::count;
    EXPECT_EQ(of_record ? octets_by_the_page(records, "## `" + name + "`")
                        : octets_by_the_page(interface, "### SID " + sid + ": " + name) * report.repeats,
              octets)
        << "SID " << sid;
    EXPECT_NE(interface.find("\n| " + sid + " | [" + name + "]("), std::string::npos) << "SID " << sid;
    EXPECT_NE(interface.find(" | " + std::to_string(octets) + " | ", interface.find("\n| " + sid + " | [" + name)),
              std::string::npos);
  }
}

TEST(GeneratedPages, TheEventsPageNamesEveryValueInPlaceOfItsMark) {
  const std::string events = page("events.md");
  EXPECT_EQ(events.find("%a"), std::string::npos);
  EXPECT_EQ(events.find("%b"), std::string::npos);
  for (std::size_t i = 0; i < ilp::status_code_limit; ++i) {
    if (!ilp::is_status_code(i)) continue;
    const auto code = static_cast<ilp::StatusCode>(i);
    const std::size_t begin = events.find("\n| " + std::to_string(i) + " `" + ilp::status_name(code) + "` ");
    ASSERT_NE(begin, std::string::npos) << i;
    const std::string row = events.substr(begin, events.find('\n', begin + 1) - begin);
    const ilp::StatusValues values = ilp::status_values(code);
    for (const ilp::StatusValue& value : {values.a, values.b}) {
      if (value.type == ilp::ValueType::none) continue;
      EXPECT_NE(row.find("*" + std::string(value.name) + "*"), std::string::npos) << row << " lacks " << value.name;
    }
  }
}

TEST(GeneratedPages, CommittedPagesAreThoseTheTablesMake) {
  const std::vector<ilp::docgen::Document> documents = ilp::docgen::generated_documents();
  ASSERT_EQ(documents.size(), 5U + 1U + 11U);
  for (const ilp::docgen::Document& document : documents) {
    std::ifstream in("docs/" + document.file, std::ios::binary);
    ASSERT_TRUE(in) << "docs/" << document.file << " is missing: run build/host/bin/ilp-docgen docs";
    const std::string committed((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    EXPECT_TRUE(!document.part || committed.find(document.text) != std::string::npos)
        << "docs/" << document.file << " has no lines that show where to place what is made";
    EXPECT_TRUE(committed == ilp::docgen::placed(document, committed))
        << "docs/" << document.file << " is out of date: run build/host/bin/ilp-docgen docs";
  }
}

TEST(GeneratedPages, TablesOfFiguresAreThoseOfTheirFiles) {
  std::multiset<std::string> named, files;
  for (const fs::directory_entry& entry : fs::directory_iterator("docs")) {
    if (entry.path().extension() != ".md") continue;
    const std::string committed = ilp::test::text_of(entry.path());
    for (const std::string& name : ilp::docgen::figures_of(committed)) named.insert(name);
    EXPECT_TRUE(committed == ilp::docgen::with_figures(committed, "docs/figures"))
        << entry.path() << " is out of date: run build/host/bin/ilp-docgen docs";
  }
  for (const fs::directory_entry& entry : fs::directory_iterator("docs/figures")) files.insert(entry.path().stem());
  EXPECT_EQ(named, files) << "each file of docs/figures stands in one page";
}

class FiguresFile : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder);
    write(R"({"command": ["a run", "of two"], "columns": [{"name": "flight"}, {"name": "error", "unit": "%"}],
              "rows": [["one", "0.10"], ["a | b", ""]]})");
  }
  void write(const std::string& json) { std::ofstream(folder / "errors.json") << json; }
  /// What is said of the page; empty where nothing is wrong.
  std::string refusal(const std::string& text) {
    return ilp::test::error_of([&] { (void)ilp::docgen::with_figures(text, folder); });
  }
  const fs::path folder = fs::path(testing::TempDir()) / "ilp-figures";
  const std::string blank = "Text.\n\n<!-- figures: errors -->\n<!-- end -->\n\nMore.\n";
};

TEST_F(FiguresFile, BecomesCommandAndTableOfItsBlock) {
  const std::string page = ilp::docgen::with_figures(blank, folder);
  EXPECT_EQ(page,
            "Text.\n\n<!-- figures: errors -->\n\n    a run\n    of two\n\n| flight | error, % |\n|---|---|\n"
            "| one | 0.10 |\n| a \\| b | |\n\n<!-- end -->\n\nMore.\n");
  EXPECT_EQ(ilp::docgen::with_figures(page, folder), page);
  std::string changed = page;
  changed.replace(changed.find("0.10"), 4, "0.11");
  EXPECT_EQ(ilp::docgen::with_figures(changed, folder), page);
}

TEST_F(FiguresFile, IsRefusedByNameWhereItIsDamagedOrMissing) {
  const std::string name = "errors.json";
  write(R"({"command": ["a run"], "columns": [{"name": "flight"}], "rows": [["one", "0.1"]]})");
  EXPECT_NE(refusal(blank).find(name), std::string::npos);
  EXPECT_NE(refusal(blank).find("0.1"), std::string::npos) << "the row is named";
  for (const char* const json :
       {R"({"command": [], "columns": [{"name": "flight"}], "rows": []})", R"({"command": ["a)",
        R"({"command": ["a run"], "columns": [{"name": "a"}], "rows": [[0.1]]})", "[]"}) {
    write(json);
    EXPECT_NE(refusal(blank).find(name), std::string::npos) << json;
  }
  fs::remove(folder / name);
  EXPECT_NE(refusal(blank).find(name), std::string::npos);
}

TEST_F(FiguresFile, HasABlockThatEnds) {
  const std::string begin = "<!-- figures: errors -->\n";
  EXPECT_NE(refusal("Text.\n\n" + begin).find("figures: errors"), std::string::npos);
  EXPECT_NE(refusal(begin + blank).find("figures: errors"), std::string::npos);
  EXPECT_NE(refusal("<!-- figures: errors\n\n" + blank).find("figures: errors"), std::string::npos);
}

}  // namespace
