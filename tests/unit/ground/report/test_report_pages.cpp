// Housekeeping and keyframes of the report's page.
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <regex>
#include <sstream>

#include "sim/ground/ground_run.hpp"
#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/report/figures.hpp"
#include "tests/support/page_text.hpp"
#include "tests/unit/ground/synthetic_flight.hpp"

namespace ilp::report {
namespace {

namespace fs = std::filesystem;

void write_housekeeping(const fs::path& file, std::uint32_t frames_released, std::int64_t product_bytes,
                        std::int64_t busy_ns) {
  StorageRecord storage{.product_bytes = product_bytes, .frames_released = frames_released};
  ComponentRecord first, second;
  first.id = 1;
  first.busy_ns = busy_ns;
  second.id = 2;
  second.busy_ns = 5;
  const std::vector<intake::RecordEntry> entries{intake::entry_of(first), intake::entry_of(second),
                                                 intake::entry_of(storage)};
  const std::vector<std::uint8_t> bytes = intake::write_record_file(entries);
  std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(bytes.data()), std::ssize(bytes));
}

std::string page_of(const fs::path& outbox, const fs::path& out, Report& report) {
  ground::GroundOptions options{.outbox = outbox, .out = out};
  std::ostringstream messages;
  report = ground::run_ground(options, messages);
  return test::page_text(out / "report.html");
}

TEST(ReportPages, HousekeepingIsPlottedInTheOrderOfTheFlightWhateverTheOrderOfTheFiles) {
  ILP_NEED_TOOL("node");
  const test::TemporaryFolder folder;
  const fs::path outbox = folder.path() / "outbox";
  test::write_outbox(test::make_flight(false), outbox);
  Report report;
  write_housekeeping(outbox / "events-000002.ilp", 40, 4'000'000, 900);
  write_housekeeping(outbox / "events-000003.ilp", 10, 1'000'000, 300);
  EXPECT_EQ(page_of(outbox, folder.path() / "two", report).find("Data held on board"), std::string::npos)
      << "two reports make no line";
  write_housekeeping(outbox / "events-000004.ilp", 20, 2'500'000, 600);
  const std::string page = page_of(outbox, folder.path() / "three", report);
  ASSERT_EQ(report.flight.housekeeping.size(), 3U);
  std::vector<std::int64_t> bytes, busy;
  for (const intake::HousekeepingReport& r : report.flight.housekeeping) {
    bytes.push_back(r.storage.product_bytes);
    busy.push_back(r.busy_ns);
  }
  EXPECT_EQ(bytes, (std::vector<std::int64_t>{1'000'000, 2'500'000, 4'000'000}));
  EXPECT_EQ(busy, (std::vector<std::int64_t>{305, 605, 905}));
  for (const char* title : {"Data held on board", "Database on board", "Processor time of the components"})
    EXPECT_NE(page.find(title), std::string::npos) << title;
}

TEST(ReportPages, EveryValueOfTheKeyframeTableHasTheTitleOfItsColumnForNarrowWindows) {
  ILP_NEED_TOOL("node");
  const test::TemporaryFolder folder;
  test::write_outbox(test::make_flight(false), folder.path() / "outbox");
  Report report;
  const std::string page = page_of(folder.path() / "outbox", folder.path() / "out", report);
  const std::size_t begin = page.find("<div class=\"scroll keyframes\">");
  ASSERT_NE(begin, std::string::npos);
  const std::string table = page.substr(begin, page.find("</table>", begin) - begin);
  const auto all = [&](const char* pattern) {
    const std::regex expression(pattern);
    std::vector<std::string> found;
    for (std::sregex_iterator at(table.begin(), table.end(), expression), end; at != end; ++at)
      found.push_back(std::regex_replace((*at)[1].str(), std::regex("<br>"), " "));
    return found;
  };
  const std::vector<std::string> titles = all("<th[^>]*>(.*?)</th>"), labels = all("<td data-title=\"([^\"]*)\"");
  ASSERT_EQ(titles.size(), 14U);
  ASSERT_EQ(labels.size(), 14 * report.flight.keyframes.size());
  EXPECT_EQ(all("(<td)").size(), labels.size());
  for (std::size_t i = 0; i < labels.size(); ++i) EXPECT_EQ(labels[i], titles[i % titles.size()]);
}

/// As a file, an event, a score or the flight's information may name it.
constexpr const char* hostile = "</script><img src=x onerror=alert(1)>";

template <std::size_t n>
void set_text(char (&field)[n], const std::string& text) {
  std::strncpy(field, text.c_str(), n - 1);
}

TEST(ReportPages, NamesFromOutsideNeverBecomeMarkup) {
  ILP_NEED_TOOL("node");
  Report report;
  report.title = hostile;
  report.info.emplace();
  report.info->source = report.info->software = report.info->profile = hostile;
  report.info->notes = {hostile};
  intake::Keyframe keyframe;
  keyframe.id = keyframe.strip_id = 1;
  keyframe.name = hostile;
  keyframe.camera.width = keyframe.camera.height = 8;
  report.flight.keyframes[1] = keyframe;
  StripResult strip;
  strip.strip.id = 1;
  strip.posed = 1;
  strip.place = hostile;
  strip.suffix = hostile;
  strip.files = {hostile};
  strip.vertices = strip.colmap.images = 1;
  strip.landing = landing::StripLanding{};
  strip.landing->fault = hostile;
  report.strips.push_back(strip);
  EventRecord event;
  set_text(event.component, "<img src=x>");
  set_text(event.place, hostile);
  report.flight.events = {event};
  ComponentRecord component;
  set_text(component.name, "<img src=x>");
  report.flight.components = {component};
  report.flight.remarks = {hostile};
  report.outbox.files.emplace_back();
  report.outbox.files.back().name = report.outbox.files.back().fault = hostile;
  report.missing.emplace_back();
  report.missing.back().what = hostile;
  control::StripControl placed;
  placed.fault = hostile;
  placed.points.emplace_back();
  placed.points.back().name = placed.points.back().fault = hostile;
  report.control = {placed};
  report.joined.apart = {{2, 1, hostile}};
  report.score.emplace();
  report.score->remarks = {hostile};

  const test::TemporaryFolder folder;
  std::ofstream file(folder / "report.html");
  write_report_html(report, file);
  file.close();
  std::ifstream in(folder / "report.html");
  const std::string page{std::istreambuf_iterator<char>(in), {}};
  EXPECT_EQ(page.find("<img src=x"), std::string::npos);
  const std::string text = test::page_text(folder / "report.html");
  EXPECT_EQ(text.find("<img src=x"), std::string::npos);
  EXPECT_EQ(text.find("\"</script"), std::string::npos);
  std::size_t shown = 0;
  for (std::size_t at = text.find("&lt;img src=x"); at != std::string::npos; at = text.find("&lt;img src=x", at + 1))
    ++shown;
  EXPECT_GE(shown, 22U) << "each of them is shown";
}

TEST(Figures, ALegendHasItsTitleItsUnitAndTheColoursOfThePicture) {
  const std::string heights = colour_legend("Height above the mean plane", {-2, 4}, "m", 400);
  EXPECT_NE(heights.find("Height above the mean plane, m<"), std::string::npos);
  EXPECT_NE(heights.find("stop offset=\"0%\" stop-color=\"rgb(68,1,84)\""), std::string::npos);
  for (const char* number : {">-2.00<", ">1.00<", ">4.00<"})
    EXPECT_NE(heights.find(number), std::string::npos) << number;
  const std::string differences = colour_legend("Map minus other model", {-3, 3}, "m", 400, host::diverging);
  EXPECT_NE(differences.find("id=\"differences\""), std::string::npos) << "one page may have both";
  EXPECT_NE(differences.find("stop offset=\"50%\" stop-color=\"rgb(247,247,247)\""), std::string::npos)
      << "no difference is white";
}

TEST(Figures, TheArrowPointsWhereTheDirectionLiesInATurnedView) {
  // The flight goes to world +y, which lies to the right of the picture: +x points downwards.
  PlanView view{.cosine = 0, .sine = 1, .width = 300, .height = 200};
  EXPECT_NE(direction_arrow(view, 0, 1, "N").find("x1=\"240.0\" y1=\"140.0\" x2=\"264.0\" y2=\"140.0\""),
            std::string::npos);
  const std::string right = direction_arrow(view, 1, 0, "x");
  EXPECT_NE(right.find("x1=\"240.0\" y1=\"140.0\" x2=\"240.0\" y2=\"164.0\""), std::string::npos);
  EXPECT_NE(right.find(">x<"), std::string::npos);
}

}  // namespace
}  // namespace ilp::report
