#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <sstream>

#include "sim/ground/ground_run.hpp"
#include "sim/ground/report/score_file.hpp"
#include "sim/host/text_format.hpp"
#include "sim/tools/score/score.hpp"
#include "tests/support/page_text.hpp"
#include "tests/support/said.hpp"
#include "tests/unit/ground/synthetic_flight.hpp"

namespace ilp::report {
namespace {
namespace fs = std::filesystem;

std::string error_of_reading(const fs::path& folder, const std::string& content) {
  const fs::path path = folder / "score.json";
  std::ofstream(path) << content;
  return test::error_of<std::exception>([&] { (void)read_score(path); });
}

TEST(ScorePage, ShowsWhatTheScorerFound) {
  ILP_NEED_TOOL("node");
  const test::TemporaryFolder folder;
  const fs::path flight = folder.path() / "flight";
  const test::SyntheticFlight made = test::make_flight(false);
  test::write_outbox(made, flight / "outbox");
  test::write_truth(made, flight / "flight" / "truth", 3, Mat3::Identity(), Vec3(1, 2, 3));
  std::ostringstream messages;
  score::ScoreOptions scoring{.flight = flight};
  score::run_score(scoring, {}, messages);

  ground::GroundOptions options{
      .outbox = flight / "outbox", .out = folder.path() / "out", .score = flight / "score.json"};
  const Report report = ground::run_ground(options, messages);
  ASSERT_TRUE(report.score);
  EXPECT_FALSE(report.score->complete) << "no flight information was left";
  ASSERT_EQ(report.score->strips.size(), 1U);
  EXPECT_EQ(report.score->strips[0].keyframes.size(), 5U);
  EXPECT_LT(report.score->strips[0].position_max_percent, 1e-6);
  EXPECT_LT(report.score->keyframes.at(4).position_error, 1e-6);
  const std::string page = test::page_text(options.out / "report.html");
  EXPECT_NE(page.find("Against the truth"), std::string::npos);
  EXPECT_NE(page.find("The flight is not complete"), std::string::npos);
  EXPECT_NE(page.find("drift to the far end"), std::string::npos);
}

/// A strip of five keyframes and one of three, against a truth that they miss by a little.
test::SyntheticFlight flight_with_a_short_strip(double miss) {
  test::SyntheticFlight flight = test::make_flight(false);
  for (std::int64_t i = 0; i < 3; ++i) {
    test::SyntheticView view = flight.views[static_cast<std::size_t>(i)];
    view.keyframe_id = 6 + i;
    view.strip_id = 2;
    view.name = "later-" + std::to_string(i) + ".png";
    flight.views.push_back(view);
  }
  flight.views[1].centre.z() += miss;
  flight.views[6].centre.y() += 40 * miss;
  return flight;
}

std::string tile_of(const std::string& page, const std::string& what) {
  const std::size_t begin = page.find("<div class=\"what\">" + what);
  return begin == std::string::npos ? "no tile " + what : page.substr(begin, page.find("</div></div>", begin) - begin);
}

TEST(ScorePage, OneFigureHasOneValueInTheScoreAndInTheReportWithAndWithoutIt) {
  ILP_NEED_TOOL("node");
  const test::TemporaryFolder folder;
  const fs::path flown = folder.path() / "flight", truth = flown / "flight" / "truth";
  test::write_outbox(flight_with_a_short_strip(0), flown / "outbox");
  test::write_truth(flight_with_a_short_strip(0.02), truth, 3, Mat3::Identity(), Vec3(1, 2, 3));
  std::ostringstream messages;
  score::ScoreOptions scoring{.flight = flown};
  score::run_score(scoring, {}, messages);
  const ScoreFile score = read_score(flown / "score.json");
  ASSERT_GT(score.summary.at("position_mean_percent"), 0.01);

  ground::GroundOptions options{.outbox = flown / "outbox", .truth = truth};
  for (const bool scored : {true, false}) {
    options.out = folder.path() / (scored ? "scored" : "unscored");
    options.score = scored ? flown / "score.json" : fs::path();
    (void)ground::run_ground(options, messages);
    const std::string page = test::page_text(options.out / "report.html");
    const std::string tile = tile_of(page, "Position error, mean");
    EXPECT_NE(tile.find(host::brief(score.summary.at("position_mean_percent")) + " <small>"), std::string::npos)
        << tile;
    EXPECT_NE(tile.find("at most " + host::brief(score.summary.at("position_max_percent")) + " %, 5 poses"),
              std::string::npos)
        << tile << ": three poses say nothing";
    EXPECT_NE(page.find("off by " + host::brief(score.summary.at("position_mean_percent")) + " %"), std::string::npos);
    // The median over all pixels and the one over the keyframes differ, so they have two names.
    const std::string depth = tile_of(page, "Depth error, median<");
    const std::string value = host::brief(score.summary.at("depth_median_percent")) + " <small>";
    EXPECT_EQ(depth.find(value) != std::string::npos, scored) << depth;
    EXPECT_EQ(page.find("Depth error, median keyframe") == std::string::npos, scored);
  }
}

TEST(ScorePage, PagesWithoutAScoreHaveNoSuchSection) {
  ILP_NEED_TOOL("node");
  const test::TemporaryFolder folder;
  test::write_outbox(test::make_flight(false), folder.path() / "outbox");
  ground::GroundOptions options{.outbox = folder.path() / "outbox", .out = folder.path() / "out"};
  std::ostringstream messages;
  (void)ground::run_ground(options, messages);
  EXPECT_EQ(test::page_text(options.out / "report.html").find("Against the truth"), std::string::npos);
}

/// Relative luminance of #rrggbb (WCAG 2.2).
double luminance(const std::string& colour) {
  const auto channel = [&](std::size_t at) {
    const double c = std::stoi(colour.substr(at, 2), nullptr, 16) / 255.0;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  };
  return 0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5);
}

TEST(Pages, TextStandsOutFromWhatIsBehindIt) {
  const test::TemporaryFolder folder;
  test::write_outbox(test::make_flight(false), folder.path() / "outbox");
  ground::GroundOptions options{.outbox = folder.path() / "outbox", .out = folder.path() / "out"};
  std::ostringstream messages;
  (void)ground::run_ground(options, messages);
  for (const char* name : {"report.html", "viewer.html"}) {
    if (!fs::exists(options.out / name)) continue;
    const std::string page = test::text_of(options.out / name);
    std::size_t schemes = 0;
    const std::regex scheme(":root ?\\{([^}]*)\\}"), entry("--([a-z]+): ?#([0-9a-f]{6}|[0-9a-f]{3})\\b");
    for (std::sregex_iterator root(page.begin(), page.end(), scheme), end; root != end; ++root, ++schemes) {
      std::map<std::string, double> light;
      const std::string inside = (*root)[1];
      for (std::sregex_iterator it(inside.begin(), inside.end(), entry); it != end; ++it) {
        const std::string hex = (*it)[2];
        const bool brief = hex.size() == 3;
        std::string colour = "#";
        for (const char c : hex) colour += std::string(brief ? 2 : 1, c);
        light[(*it)[1]] = luminance(colour);
      }
      for (const char* text : {"ink", "muted", "accent", "good", "warn", "bad"}) {
        for (const char* behind : {"page", "card"}) {
          const double a = light.at(text), b = light.at(behind);
          EXPECT_GE((std::max(a, b) + 0.05) / (std::min(a, b) + 0.05), 4.5) << name << ": " << text << " on " << behind;
        }
      }
    }
    EXPECT_EQ(schemes, 2U) << name << ": light and dark";
  }
}

TEST(ScoreLines, SayWhatWasMeasuredAndNothingElse) {
  ScoreFile score{.complete = true};
  score.summary = {{"position_mean_percent", 0.0123},  {"position_max_percent", 0.5}, {"rotation_mean_deg", 0.25},
                   {"height_median_percent", unknown}, {"completeness", 0.5},         {"sigma1_share", unknown}};
  ASSERT_EQ(score_lines(score).size(), 1U);
  EXPECT_NE(score_lines(score)[0].find("mean 0.012 %, largest 0.500 %"), std::string::npos) << score_lines(score)[0];
  score.complete = false;
  score.summary["height_median_percent"] = 0.75;
  score.summary["sigma1_share"] = 0.5;
  const std::vector<std::string> lines = score_lines(score);
  ASSERT_EQ(lines.size(), 4U);
  EXPECT_NE(lines[0].find("not complete"), std::string::npos);
  EXPECT_NE(lines[2].find("depth on 50 % of the new ground"), std::string::npos) << lines[2];
  EXPECT_EQ(lines[3].find("depth errors"), std::string::npos) << lines[3];
}

TEST(ScorePage, WhatIsUnknownStaysUnknown) {
  const test::TemporaryFolder folder;
  const fs::path path = folder.path() / "score.json";
  std::ofstream(path) << R"({"version": 1, "summary": {"drift_percent": null, "bow_percent": 2.5},
                             "strips": [{"id": 3, "length": null, "bow": null}],
                             "keyframes": [{"id": 1, "strip": 3, "true_centre": [1, null, 2]}]})";
  const ScoreFile score = read_score(path);
  EXPECT_TRUE(std::isnan(score.summary.at("drift_percent")));
  EXPECT_EQ(score.summary.at("bow_percent"), 2.5);
  EXPECT_TRUE(std::isnan(score.strips.at(0).length));
  EXPECT_FALSE(score.strips[0].bow_fit);
  EXPECT_TRUE(score.strips[0].keyframes.empty()) << "a centre with two numbers is none";
}

TEST(ScorePage, DamagedScoresAreNamed) {
  const test::TemporaryFolder folder;
  for (const char* content : {"", "{\"version\": 1, \"summ", "[1, 2]", "{\"version\": 2, \"summary\": {}}",
                              "{\"version\": 1, \"summary\": 7}", "{\"version\": \"1\", \"summary\": {}}"}) {
    const std::string message = error_of_reading(folder.path(), content);
    EXPECT_NE(message.find("score.json is no score"), std::string::npos) << content;
  }
  EXPECT_EQ(error_of_reading(folder.path(), R"({"version": 1, "summary": {}, "strips": 5, "keyframes": [7, "x", []]})"),
            "");
}

}  // namespace
}  // namespace ilp::report
