// The data and the page of the viewer, over the flight above a known plane.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "sim/ground/ground_run.hpp"
#include "sim/ground/viewer/viewer_data.hpp"
#include "sim/ground/viewer/viewer_page.hpp"
#include "sim/host/files.hpp"
#include "sim/host/picture.hpp"
#include "tests/support/page_text.hpp"
#include "tests/unit/ground/synthetic_flight.hpp"

namespace ilp::viewer {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

std::vector<std::uint8_t> decoded(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<std::uint8_t> bytes;
  std::uint32_t bits = 0, count = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = (bits << 6U) | static_cast<std::uint32_t>(digits.find(c));
    count += 6;
    if (count >= 8) bytes.push_back(static_cast<std::uint8_t>(bits >> (count -= 8)));
  }
  return bytes;
}

template <typename T>
std::vector<T> array_of(const json& text) {
  const std::vector<std::uint8_t> bytes = decoded(text.get<std::string>());
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

std::string text_of(const fs::path& path) {
  const auto bytes = host::read_file(path);
  return {bytes.begin(), bytes.end()};
}

/// The flight as the page has it. Node runs its script.
json flight_of(const report::Report& report) {
  const test::TemporaryFolder folder;
  host::update_file(folder / "viewer.html", [&](std::ostream& out) { write_viewer_html(report, out); });
  const test::ToolResult run =
      test::run_tool("node tests/support/viewer_flight.mjs " + test::quoted(folder / "viewer.html"));
  EXPECT_EQ(run.status, 0) << run.output;
  return json::parse(run.output, nullptr, false);
}

class ViewerTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<test::TemporaryFolder>();
    const test::SyntheticFlight flight = test::make_flight(false);
    test::write_outbox(flight, folder_->path() / "outbox");
    ground::GroundOptions options;
    options.outbox = folder_->path() / "outbox";
    options.out = folder_->path() / "result";
    options.title = "A </script> \xff title";
    std::ostringstream messages;
    report_ = std::make_unique<report::Report>(ground::run_ground(options, messages));
  }
  static void TearDownTestSuite() {
    report_.reset();
    folder_.reset();
  }

  static inline std::unique_ptr<test::TemporaryFolder> folder_;
  static inline std::unique_ptr<report::Report> report_;
};

TEST_F(ViewerTest, TheFlightIsThatOfTheReportWithWhatOnlyTheViewerNeeds) {
  ILP_NEED_TOOL("node");
  report::Report reported = *report_;
  for (int i = 0; i < 3; ++i)
    reported.flight.overlaps[i] = {.keyframe_id = i, .verdict = OverlapVerdict::ok, .overlap = 0.9F};
  reported.flight.frames[2] = {.time_ns = 7'500'000'000};
  EventRecord event;
  event.time_ns = 2'000'000'000;
  event.severity = static_cast<std::uint8_t>(Severity::high);
  reported.flight.events = {event};
  const json flight = flight_of(reported);
  EXPECT_EQ(flight["totals"]["final_poses"], 5);
  ASSERT_EQ(flight["keyframes"].size(), 5U);
  const intake::Keyframe& second = reported.flight.keyframes.at(2);
  const json& shown = flight["keyframes"][1];
  EXPECT_EQ(shown["image"]["bytes"], second.product(ProductKind::image)->bytes);
  EXPECT_NEAR(shown["time_s"].get<double>(), static_cast<double>(second.record->time_ns) / 1e9, 1e-9);
  EXPECT_NEAR(shown["overlap"].get<double>(), second.record->overlap, 1e-6);
  EXPECT_FALSE(flight["keyframes"][0].contains("overlap")) << "the first has nothing before it";
  EXPECT_NEAR(shown["pose"]["centre"][0].get<double>(), second.pose->centre[0], 1e-9);
  EXPECT_EQ(shown["pose"]["covariance"].size(), 6U);
  EXPECT_EQ(flight["strips"][0]["members"], 5);
  EXPECT_GT(flight["strips"][0]["grid"]["covered"].get<int>(), 1000);
  EXPECT_EQ(flight["timeline"]["overlaps"], (json{{7.5, 0.9F}})) << "of frames with a time, after the first keyframe";
  EXPECT_EQ(flight["timeline"]["events"]["list"][0]["severity"], 3);
  EXPECT_EQ(flight["timeline"]["events"]["list"][0]["time_s"], 2);
}

TEST_F(ViewerTest, AStripSaysHowWellTheVehicleKnowsWhereItIs) {
  ILP_NEED_TOOL("node");
  report::Report measured = *report_;
  EXPECT_TRUE(flight_of(measured)["strips"][0]["navigation"].is_null()) << "no measurements came";
  StripFrameRecord frame{.verdict = StripFrameVerdict::ok, .scale_sigma = 0.002, .tilt_sigma_rad = 0.01};
  measured.strips[0].strip.frame = frame;
  const test::TemporaryFolder folder;
  host::update_file(folder / "report.html", [&](std::ostream& out) { write_report_html(measured, out); });
  const std::string page = test::page_text(folder / "report.html");
  const std::string wanted =
      "navigation: scale 0.200 %, tilt 0.573°, heading not known, place not known (one sigma; the measurements agree)";
  EXPECT_NE(page.find(wanted), std::string::npos) << page.substr(page.find("navigation: scale"), 200);
}

TEST_F(ViewerTest, HeightsAreTheCellsOfTheGrid) {
  const map::GroundGrid& grid = *report_->strips[0].grid;
  const json reported = viewer_strip(*report_, report_->strips[0])["grid"];
  const auto cover = array_of<std::uint8_t>(reported["cover"]);
  const auto heights = array_of<float>(reported["heights"]);
  const auto source = array_of<std::uint16_t>(reported["source"]);
  const std::int32_t width = reported["width"], height = reported["height"], stride = reported["stride"];
  std::size_t next = 0;
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      const auto cell = static_cast<std::size_t>(y * width + x);
      const float expected = grid.height.at(x * stride, y * stride);
      ASSERT_EQ(((cover[cell / 8] >> (cell % 8)) & 1) != 0, std::isfinite(expected));
      if (!std::isfinite(expected)) continue;
      ASSERT_EQ(heights.at(next), expected);
      ASSERT_EQ(source.at(next), grid.source.at(x * stride, y * stride));
      ++next;
    }
  }
  EXPECT_EQ(next, heights.size());
  EXPECT_GT(next, 1000U);
  EXPECT_DOUBLE_EQ(reported["cell"].get<double>(), grid.cell * stride);
}

TEST_F(ViewerTest, TheSurfaceKeepsToItsBudget) {
  ViewerBudget budget{.vertices = 2000, .texture_side_px = 64};
  const json strip = viewer_strip(*report_, report_->strips[0], budget);
  EXPECT_LE(array_of<float>(strip["grid"]["heights"]).size(), budget.vertices);
  EXPECT_GT(strip["grid"]["stride"].get<int>(), 1);
  EXPECT_GT(strip["grid"]["texture_stride"].get<int>(), 1);
}

TEST_F(ViewerTest, FootprintsLieOnTheGroundWhereTheImageEnds) {
  for (const auto& [id, k] : report_->flight.keyframes) {
    const json keyframe = viewer_keyframe(*report_, k);
    const auto outline = keyframe["footprint"].get<std::vector<double>>();
    ASSERT_EQ(outline.size(), 72U);
    const Pose pose = pose_of(*k.pose);
    for (std::size_t i = 0; i < outline.size(); i += 3) {
      EXPECT_NEAR(outline[i + 2], test::plane_height(outline[i], outline[i + 1]), 0.05);
    }
    const double middle_x = 0.5 * (outline[0] + outline[36]), middle_y = 0.5 * (outline[1] + outline[37]);
    EXPECT_LT(std::hypot(middle_x - pose.centre[0], middle_y - pose.centre[1]), 5);
  }
}

TEST_F(ViewerTest, AFootprintThatMissesTheGroundIsNone) {
  intake::Keyframe k = report_->flight.keyframes.begin()->second;
  const double up[] = {1, 0, 0, 0};
  std::memcpy(k.pose->q_cam_from_world, up, sizeof up);
  EXPECT_TRUE(exports::footprint_of(k, report_->strips[0]).empty());
}

TEST_F(ViewerTest, KeyframesCarryTheirPictures) {
  // Pictures are in the page only, because a run does not hold those of all keyframes.
  std::ifstream in(folder_->path() / "result" / "viewer.html");
  const std::string page((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const std::string picture = "\"image\":\"data:image/png;base64,";
  std::size_t pictures = 0;
  for (std::size_t at = page.find(picture); at != std::string::npos; at = page.find(picture, at + 1)) ++pictures;
  EXPECT_EQ(pictures, 5U);
}

TEST_F(ViewerTest, LinksCarryTheirVerdictAndWhatTheModelMakesOfThem) {
  ILP_NEED_TOOL("node");
  EXPECT_TRUE(flight_of(*report_)["links"].empty()) << "the flight has none";
  report::Report linked = *report_;
  LinkRecord closed, images;
  closed.keyframe_id = 5;
  closed.place_id = 1;
  closed.verdict = LinkVerdict::contradicts_poses;
  images.keyframe_id = 4;
  images.place_id = 1;
  images.verdict = LinkVerdict::images_only;
  linked.flight.links = {closed, images};
  model::JoinedModel joined;
  model::ClosedLink in_model{.place_id = 1, .keyframe_id = 5, .points = 40, .after_px = 0.25};
  joined.links = {in_model};
  linked.joined.models = {joined};
  const json links = flight_of(linked)["links"];
  ASSERT_EQ(links.size(), 2U);
  EXPECT_EQ(
      links[0],
      (json{{"keyframe", 5}, {"place", 1}, {"verdict", "contradicts_poses"}, {"points", 40}, {"error_px", 0.25}}));
  EXPECT_EQ(links[1], (json{{"keyframe", 4}, {"place", 1}, {"verdict", "images_only"}}));
}

TEST_F(ViewerTest, WhatCameDownNeverEndsItsElement) {
  if (!viewer_available()) GTEST_SKIP() << "this build has no viewer";
  const std::string page = text_of(folder_->path() / "result" / "viewer.html");
  const std::string open = "<script type=\"application/json\" id=\"flight\">";
  const std::size_t begin = page.find(open) + open.size();
  EXPECT_EQ(json::parse(page.substr(begin, page.find("</script>", begin) - begin))["keyframes"].size(), 5U);
  ILP_NEED_TOOL("node");
  EXPECT_EQ(flight_of(*report_)["title"], "A </script> \xEF\xBF\xBD title");
  EXPECT_NE(test::page_text(folder_->path() / "result" / "report.html").find("href=\"viewer.html\""),
            std::string::npos);
}

TEST_F(ViewerTest, AnEmptyDownlinkLeavesAPageThatSaysSoAndNoOtherResultIsLost) {
  const test::TemporaryFolder folder;
  ground::GroundOptions options{.outbox = folder.path() / "outbox", .out = folder.path() / "result"};
  fs::create_directories(options.outbox);
  std::ostringstream messages;
  EXPECT_THROW((void)ground::run_ground(options, messages), std::runtime_error);
  if (!viewer_available()) GTEST_SKIP() << "this build has no viewer";
  EXPECT_NE(text_of(options.out / "viewer.html").find("the folder is empty"), std::string::npos);

  // What came before is in the catalogue and counts.
  options.out = folder_->path() / "result";
  const std::string before = text_of(options.out / "viewer.html");
  options.title = "A </script> \xFF title";
  (void)ground::run_ground(options, messages);
  EXPECT_EQ(text_of(options.out / "viewer.html"), before);
}

TEST(Base64, IsThatOfTheStandard) {
  const auto of = [](const std::string& text) {
    return host::base64({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  };
  EXPECT_EQ(of(""), "");
  EXPECT_EQ(of("f"), "Zg==");
  EXPECT_EQ(of("fo"), "Zm8=");
  EXPECT_EQ(of("foobar"), "Zm9vYmFy");
}

}  // namespace
}  // namespace ilp::viewer
