// The pages that follow from tables in the code say what the tables say.

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>

#include "bsp/flight/status_text.hpp"
#include "fsw/base/status.hpp"
#include "fsw/packets/report_table.hpp"
#include "sim/tools/docgen/documents.hpp"

namespace {

std::string page(const std::string& name) {
  std::ifstream in("docs/" + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
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

}  // namespace
