// Every program and subcommand answers --help with what it does, an example and its exit statuses, ends a wrong call
// with 2, and has a manual page.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/unit/ground/export/tool.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;
using test::ToolResult;

const fs::path programs = ILP_PROGRAMS, sources = ILP_SOURCE;

struct Program {
  std::string name;
  std::vector<std::string> subcommands;
};
const std::vector<Program> all = {
    {"ilp-board-station", {}},
    {"ilp-camera-check", {}},
    {"ilp-compute-vulkan", {}},
    {"ilp-docgen", {}},
    {"ilp-gps", {}},
    {"ilp-ground", {"merge", "work", "compare", "map-tiles", "map-check", "serve", "console"}},
    {"ilp-lab",
     {"overlap", "match", "relpose", "fundamental", "homography", "bundle", "calibrate-target", "rectify", "stereo",
      "encode", "richness", "pose-strip", "select", "world-map"}},
    {"ilp-onboard", {}},
    {"ilp-richness", {"evaluate", "stability", "tune", "sheet"}},
    {"ilp-score", {}},
    {"ilp-sil", {}},
    {"ilp-store", {"digest", "rows", "create", "roles"}},
    {"ilp-xtce", {}}};
struct Script {
  std::string path, name;
};
const std::vector<Script> scripts = {{"sim/fly", "sim/fly"},
                                     {"sim/campaign", "sim/campaign"},
                                     {"bsp/packages/ilp-campaign", "ilp-campaign"},
                                     {"bsp/packages/ilp-formats", "ilp-formats"},
                                     {"bsp/packages/ilp-merge", "ilp-merge"},
                                     {"bsp/packages/ilp-tiles3d", "ilp-tiles3d"},
                                     {"sim/tools/campaign/campaign.py", "sim/campaign"}};

ToolResult call(const std::string& words) {
  return test::run_tool(words + " 2>&1 </dev/null");
}

/// Programs that this build has.
std::vector<Program> built() {
  std::vector<Program> found;
  for (const Program& program : all) {
    if (fs::exists(programs / program.name)) found.push_back(program);
  }
  return found;
}

std::set<std::string> subcommands_in(const std::string& help) {
  std::set<std::string> names;
  std::istringstream lines(help.substr(std::min(help.find("\nSubcommands") + 1, help.size())));
  std::string line;
  if (!std::getline(lines, line) || !line.starts_with("Subcommands")) return names;
  while (std::getline(lines, line) && line.starts_with("  ")) {
    std::string name;
    std::istringstream(line) >> name;
    // What does not fit beside a name stands on a line of its own.
    if (line[2] != ' ') names.insert(name);
  }
  return names;
}

void expect_helpful(const std::string& words, const std::string& name) {
  const ToolResult help = call(words + " --help");
  EXPECT_EQ(help.status, 0) << words << "\n" << help.output;
  EXPECT_GT(help.output.find('\n'), 20U) << words << " does not say what it does\n" << help.output;
  EXPECT_NE(help.output.find("Example: "), std::string::npos) << words << "\n" << help.output;
  EXPECT_NE(help.output.find(name, std::min(help.output.find("Example: "), help.output.size())), std::string::npos)
      << words << ": the example is another program's\n"
      << help.output;
  EXPECT_NE(help.output.find("Exit status: "), std::string::npos) << words << "\n" << help.output;
  EXPECT_NE(help.output.find(" 2 "), std::string::npos) << words << "\n" << help.output;
}

TEST(Help, OfEveryProgramAndSubcommandSaysWhatItDoesWithAnExampleAndTheExitStatuses) {
  for (const Program& program : built()) {
    const std::string words = programs / program.name;
    expect_helpful(words, program.name);
    for (const std::string& subcommand : program.subcommands) expect_helpful(words + " " + subcommand, program.name);
  }
  for (const Script& script : scripts) expect_helpful(sources / script.path, script.name);
}

TEST(Help, NothingIsLeftOutOfThisTest) {
  std::set<std::string> known;
  for (const Program& program : all) known.insert(program.name);
  for (const auto& entry : fs::directory_iterator(programs)) {
    const std::string name = entry.path().filename();
    const bool of_tests = name.ends_with("-faults");
    EXPECT_TRUE(!name.starts_with("ilp-") || of_tests || known.contains(name)) << name;
  }
  for (const Program& program : built()) {
    const std::set<std::string> expected(program.subcommands.begin(), program.subcommands.end());
    EXPECT_EQ(subcommands_in(call((programs / program.name).string() + " --help").output), expected) << program.name;
  }
}

TEST(Help, AWrongCallEndsWithTwo) {
  for (const Program& program : built()) {
    const std::string words = programs / program.name;
    EXPECT_EQ(call(words + " --no-such-option").status, 2) << words;
    for (const std::string& subcommand : program.subcommands) {
      const ToolResult result = call(words + " " + subcommand + " --no-such-option");
      EXPECT_EQ(result.status, 2) << words << " " << subcommand << "\n" << result.output;
    }
  }
  EXPECT_EQ(call((sources / "sim/tools/campaign/campaign.py").string() + " --no-such-option").status, 2);
  EXPECT_EQ(call((sources / "sim/campaign").string() + " --no-such-option").status, 2);
  const std::string fly = (sources / "sim/fly").string() + " --programs " + programs.string() + " ";
  EXPECT_EQ(call(fly + "--no-such-option").status, 2);
  for (const char* option : {"--out", "--out=", "--out --keep", "--keep", "--keep some", "--reference", "--images"})
    EXPECT_EQ(call(fly + option).status, 2) << option;
  EXPECT_EQ(call((sources / "sim/fly").string() + " --programs").status, 2);
}

struct Mistake {
  const char* words;
  const char* reported;
};
TEST(Help, NearestRightWordIsNamed) {
  const std::vector<Mistake> mistakes = {
      {"ilp-sil --imagse images --out out", "--imagse is no option; did you mean --images?"},
      {"ilp-ground outbox --ot ground", "--ot is no option; did you mean --out?"},
      {"ilp-ground serv flight", "serv is neither a folder nor a subcommand; did you mean serve?"},
      {"ilp-ground compare a b --fitt=none", "--fitt is no option; did you mean --fit?"},
      {"ilp-lab overlapp a.png b.png", "overlapp is no subcommand; did you mean overlap?"},
      {"ilp-lab stereo a b --matchr x", "--matchr is no option; did you mean --matcher?"},
      {"ilp-store digst flight.db", "digst is no subcommand; did you mean digest?"},
      {"ilp-score flight --refernce poses.txt", "--refernce is no option; did you mean --reference?"},
      {"ilp-onboard --stor flight.db", "--stor is no option, the nearest is --store"},
      {"ilp-sil --seed -1 --out out", "'-1' is no whole number from 0"},
      {"ilp-sil --exif-sigma nan --out out", "'nan' is no finite number"},
      {"ilp-sil --exif-sigma 20000 --out out", "10000"},
      {"ilp-ground outbox --out ground --target-overlap 2", "not in range 0.000000 to 1.000000"}};
  for (const Mistake& mistake : mistakes) {
    if (!fs::exists(programs / std::string(mistake.words).substr(0, std::string(mistake.words).find(' ')))) continue;
    const ToolResult result = call((programs / mistake.words).string());
    EXPECT_EQ(result.status, 2) << mistake.words << "\n" << result.output;
    EXPECT_NE(result.output.find(mistake.reported), std::string::npos) << mistake.words << "\n" << result.output;
  }
}

TEST(Help, StatesDefaults) {
  const auto says = [](const char* words, const char* text) {
    const std::string help = call((programs / words).string() + " --help").output;
    EXPECT_NE(help.find(text), std::string::npos) << help;
  };
  says("ilp-sil", "--exif-sigma FLOAT:FLOAT in [0 - 10000]=5\n");
  says("ilp-ground serve", "--listen TEXT=127.0.0.1:8080");
  says("ilp-lab stereo", "--matcher TEXT:{");
  says("ilp-ground map-check", "=10\n");
  const std::string tiles = call((programs / "ilp-ground map-tiles").string() + " --help").output;
  EXPECT_EQ(tiles.find("=0 REQUIRED"), std::string::npos) << "what has to be given has no default\n" << tiles;
}

TEST(Help, BecomesTheManualPages) {
  ILP_NEED_TOOL("zcat");
  const test::TemporaryFolder folder;
  for (const Program& program : built()) {
    if (program.name == "ilp-gps" || program.name == "ilp-docgen" || program.name == "ilp-board-station" ||
        program.name == "ilp-compute-vulkan")
      continue;  // they are not installed
    const fs::path page = folder / (program.name + ".1.gz");
    const ToolResult made = call((sources / "bsp/packages/man-page").string() + " " + test::quoted(page) + " " +
                                 program.name + " " + (programs / program.name).string());
    ASSERT_EQ(made.status, 0) << program.name << "\n" << made.output;
    const std::string text = call("zcat " + test::quoted(page)).output;
    EXPECT_TRUE(text.starts_with(".TH ILP")) << text;
    std::size_t sections = 0;
    for (std::size_t at = text.find("\n.SH "); at != std::string::npos; at = text.find("\n.SH ", at + 1)) ++sections;
    EXPECT_EQ(sections, 2 + program.subcommands.size()) << text;
    std::size_t examples = 0;
    for (std::size_t at = text.find("Example: "); at != std::string::npos; at = text.find("Example: ", at + 1))
      ++examples;
    EXPECT_EQ(examples, 1 + program.subcommands.size()) << text;
    EXPECT_EQ(text.find(programs.string()), std::string::npos) << "a path of the build";
  }
}

}  // namespace
}  // namespace ilp
