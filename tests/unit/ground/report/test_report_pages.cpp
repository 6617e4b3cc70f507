// Housekeeping and keyframes of the report's page.
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <regex>
#include <sstream>

#include "sim/ground/ground_run.hpp"
#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/report/json_writer.hpp"
#include "sim/ground/report/map_pictures.hpp"
#include "sim/ground/report/page.hpp"
#include "tests/support/page_text.hpp"
#include "tests/support/said.hpp"
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
  const std::string page = test::text_of(folder / "report.html");
  EXPECT_EQ(page.find("<img src=x"), std::string::npos);
  const std::string text = test::page_text(folder / "report.html");
  EXPECT_EQ(text.find("<img src=x"), std::string::npos);
  EXPECT_EQ(text.find("\"</script"), std::string::npos);
  std::size_t shown = 0;
  for (std::size_t at = text.find("&lt;img src=x"); at != std::string::npos; at = text.find("&lt;img src=x", at + 1))
    ++shown;
  EXPECT_GE(shown, 22U) << "each of them is shown";
}

/// Of a page whose flight has one strip, flown to world +y, which lies to the right of the pictures: +x points
/// downwards.
std::string page_with_figures(const Json& north) {
  Report report;
  StripResult strip;
  strip.strip.id = 1;
  strip.posed = 2;
  landing::LandingSite site;
  site.x = 3;
  site.y = 40;
  strip.landing.emplace().map.emplace().sites = {site};
  report.strips.push_back(strip);
  for (const std::int64_t id : {1, 2}) {
    intake::Keyframe& keyframe = report.flight.keyframes[id];
    keyframe.id = id;
    keyframe.strip_id = 1;
    keyframe.pose.emplace();
    keyframe.pose->state = PoseState::final;
    keyframe.pose->centre[0] = 3;
    keyframe.pose->centre[1] = 20 * static_cast<double>(id);
  }
  PlanView view{
      .cosine = 0, .sine = 1, .along_low = 10, .across_high = 7, .unit_per_px = 0.5, .width = 300, .height = 200};
  Json figure = picture_json(view, "data:,image");
  figure["north"] = north;
  figure["heights"] = coloured_picture_json(view, "data:,heights", {-2, 4}, host::viridis);
  figure["heights"]["exaggeration"] = 1;
  Json landing = figure["heights"];
  landing["footprint_px"] = 24;
  const test::TemporaryFolder folder;
  std::ofstream file(folder / "page.html");
  write_page("Figures", "",
             {{"report", [&](std::ostream& out) { write_report_json(report, out, JsonStyle::compact); }},
              {"pictures",
               [&](std::ostream& out) {
                 out << Json{{"figures", {{"strip 1", figure}, {"landing 1", landing}}},
                             {"keyframes", {{"1", Json::object()}, {"2", Json::object()}}}};
               }}},
             file);
  file.close();
  return test::page_text(folder / "page.html");
}

TEST(Figures, TheTrackLiesOnThePictureWhereTheWorldDoes) {
  ILP_NEED_TOOL("node");
  const std::string page = page_with_figures(nullptr);
  // Along: (20 - 10) / 0.5 and (40 - 10) / 0.5; across, to the left, is -x: (7 + 3) / 0.5.
  EXPECT_NE(page.find("class=\"track\" points=\"20.0,20.0 60.0,20.0\""), std::string::npos);
  EXPECT_NE(page.find("<image width=\"300\" height=\"200\" href=\"data:,image\"/>"), std::string::npos);
  // 0.18 of 150 units is 27: the bar is 20 long, which are 40 px.
  EXPECT_NE(page.find("points=\"16.0,184.0 56.0,184.0\""), std::string::npos);
  EXPECT_NE(page.find(">20.0 units</text>"), std::string::npos);
}

TEST(Figures, TheArrowPointsWhereTheDirectionLiesInATurnedView) {
  ILP_NEED_TOOL("node");
  const std::string along = page_with_figures({0, 1}), down = page_with_figures({1, 0}),
                    none = page_with_figures(nullptr);
  EXPECT_NE(along.find("points=\"240.0,140.0 264.0,140.0\""), std::string::npos);
  EXPECT_NE(down.find("points=\"240.0,140.0 240.0,164.0\""), std::string::npos);
  EXPECT_NE(down.find(">N</text>"), std::string::npos);
  EXPECT_NE(none.find("points=\"240.0,140.0 264.0,140.0\""), std::string::npos) << "the y axis of the world";
  EXPECT_EQ(none.find(">N</text>"), std::string::npos);
}

TEST(Figures, ALandingSiteIsACircleOfTheFootprintAroundItsPlaceWithItsRank) {
  ILP_NEED_TOOL("node");
  const std::string page = page_with_figures(nullptr);
  EXPECT_NE(page.find("<circle class=\"track\" cx=\"60.0\" cy=\"20.0\" r=\"12\"><title>rank 1</title>"),
            std::string::npos);
  EXPECT_NE(page.find("x=\"60.0\" y=\"8.0\" text-anchor=\"middle\">1</text>"), std::string::npos);
}

TEST(Figures, HeightErrorsAreCutToWhatWasComparedAndZeroIsInTheMiddle) {
  Report report;
  host::Raster<float>& errors = report.score.emplace().height_error;
  errors = host::Raster<float>(6, 5, std::nanf(""));
  errors.at(2, 1) = -1;
  errors.at(4, 2) = 3;
  std::map<std::string, Json> figures;
  std::vector<std::uint8_t> kept;
  map_figures(
      report,
      [&](const std::string& name, const std::vector<std::uint8_t>& png) {
        kept = png;
        return name;
      },
      [&](const std::string& name, const Json& figure) { figures[name] = figure; });
  ASSERT_EQ(figures.size(), 1U);
  const Json& figure = figures.at("height errors");
  EXPECT_EQ(figure["view"]["width"], 3);
  EXPECT_EQ(figure["view"]["height"], 2);
  ASSERT_GT(kept.size(), 24U);
  EXPECT_EQ(kept[19], 3) << "the width of the PNG";
  EXPECT_EQ(kept[23], 2);
  EXPECT_EQ(figure["href"], "height-errors");
  EXPECT_DOUBLE_EQ(figure["range"][0].get<double>(), -figure["range"][1].get<double>());
  EXPECT_NEAR(figure["range"][1].get<double>(), 3, 0.2);
  report.score->height_error = host::Raster<float>(6, 5, std::nanf(""));
  map_figures(
      report, [](const std::string& name, const auto&) { return name; },
      [](const std::string& name, const Json&) { FAIL() << name << ", where nothing was compared"; });
}

TEST(Figures, ALegendHasItsTitleItsUnitAndTheColoursOfThePicture) {
  ILP_NEED_TOOL("node");
  const std::string page = page_with_figures(nullptr);
  EXPECT_NE(page.find("Height above the mean plane, units<"), std::string::npos);
  EXPECT_NE(page.find("stop offset=\"0%\" stop-color=\"rgb(68,1,84)\""), std::string::npos);
  for (const char* number : {">-2.00<", ">1.00<", ">4.00<"}) EXPECT_NE(page.find(number), std::string::npos) << number;
  const Json differences = coloured_picture_json({}, "", {-3, 3}, host::diverging);
  EXPECT_EQ(differences["colours"][5], "rgb(247,247,247)") << "no difference is white";
}

}  // namespace
}  // namespace ilp::report
