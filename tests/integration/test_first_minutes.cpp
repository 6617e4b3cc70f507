// What a new user sees first: the demo as a whole, and how far the build and a flight have come.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/unit/ground/export/tool.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {

using test::run_tool;

const std::string source = ILP_SOURCE;

TEST(FirstMinutes, TheDemoFliesAsARecordedStripAndItsReportHasItsPosesAndHeights) {
  const test::TemporaryFolder folder;
  const std::string out = folder / "with blank";
  const test::ToolResult run = run_tool(test::quoted(source + "/sim/fly") +
                                        " --demo --programs " ILP_PROGRAMS " --out " + test::quoted(out) + " 2>&1");
  ASSERT_EQ(run.status, 0) << run.output;
  EXPECT_NE(run.output.find(out + "/ground/report.html"), std::string::npos) << run.output;
  const nlohmann::json report = nlohmann::json::parse(std::ifstream(out + "/ground/report.json"));
  EXPECT_GE(report["totals"]["final_poses"].get<int>(), 14);
  EXPECT_GE(report["totals"]["with_depth"].get<int>(), 13);
  EXPECT_EQ(report["strips"].size(), 1U);
  EXPECT_EQ(report["camera"]["width"].get<int>(), 320);
  const nlohmann::json score = nlohmann::json::parse(std::ifstream(out + "/score.json"));
  EXPECT_EQ(score["summary"]["frames"].get<double>(), 20);
  EXPECT_LT(score["summary"]["position_mean_percent"].get<double>(), 0.1);
  const std::string page = run_tool("cat " + test::quoted(out + "/ground/report.html")).output;
  EXPECT_NE(page.find("Demo: a canyon"), std::string::npos);
  // By default nothing is kept that another file has.
  const std::string copies =
      run_tool("find " + test::quoted(out) + " -name '*.pfm' -o -name 'model.ply' -o -name 'catalogue.db*'").output;
  EXPECT_EQ(copies, "");
}

std::string shown_for(const std::string& ninja) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "ninja.txt") << ninja;
  const test::ToolResult run =
      run_tool(test::quoted(source + "/bsp/build-programs") + " --progress " + test::quoted(folder / "log.txt") + " <" +
               test::quoted(folder / "ninja.txt") + " 2>&1");
  EXPECT_EQ(run.status, 0);
  EXPECT_EQ(run_tool("cat " + test::quoted(folder / "log.txt")).output, ninja) << "the log of a build that fails";
  return run.output;
}

TEST(FirstMinutes, TheBuildTellsNowAndThenHowLongItStillTakes) {
  EXPECT_EQ(
      shown_for("-- Configuring done\n[1/160 1.250] Building a\n[40/160 30.1] Building b\n[41/160 30.9] Building c\n"
                "[80/160 240.0] Building d\n[160/160 410.0] Linking e\n"),
      "Building: 40 of 160, about 90 s left\nBuilding: 80 of 160, about 4 min left\n");
  EXPECT_EQ(shown_for("[1/2 0.010] Building a\n[2/2 0.200] Linking b\n"), "") << "short work";
  EXPECT_EQ(shown_for("[3/9 20.5] \n[0/9 99.0] x\nFAILED: [4/9 60.0]\n"), "Building: 3 of 9, about 40 s left\n");
}

}  // namespace
}  // namespace ilp
