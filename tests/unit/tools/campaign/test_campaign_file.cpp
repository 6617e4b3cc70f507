// Campaign files: what they expand to, and what is said of bad ones.

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "sim/tools/campaign/campaign_file.hpp"
#include "sim/tools/campaign/job_grid.hpp"
#include "tests/unit/host/scratch_folder.hpp"

namespace ilp::batch {
namespace {

using test::says;
using test::ScratchFolder;
using Texts = std::vector<std::string>;

std::vector<Job> jobs_of(const std::string& text) {
  const ScratchFolder folder;
  return expand(read_campaign(folder.write("c.ini", text)));
}

Texts names_of(const std::string& text) {
  Texts names;
  for (const Job& job : jobs_of(text)) names.push_back(job.name);
  return names;
}

std::string refusal(const std::string& text) {
  return test::error_of([&] { (void)jobs_of(text); });
}

TEST(CampaignFile, GridIsTheCartesianProductWithTheLastAxisFastest) {
  EXPECT_EQ(names_of("[grid]\nscenario = flat | mars-plains\nworld.ruggedness = 0 | 0.5\nseed = 1..2\n"),
            (Texts{"flat_ruggedness=0_seed=1", "flat_ruggedness=0_seed=2", "flat_ruggedness=0.5_seed=1",
                   "flat_ruggedness=0.5_seed=2", "mars-plains_ruggedness=0_seed=1", "mars-plains_ruggedness=0_seed=2",
                   "mars-plains_ruggedness=0.5_seed=1", "mars-plains_ruggedness=0.5_seed=2"}));
}

TEST(CampaignFile, ArgumentsCarryScenarioSettingsSeedAndFrames) {
  const auto jobs = jobs_of(
      "[campaign]\nframes = 12\n[grid]\nscenario = flat\nflight.kind = line\nseed = 7\n"
      "[set]\neffects.haze = 0.1\nflight.kind = balloon\n");
  ASSERT_EQ(jobs.size(), 1U);
  EXPECT_EQ(flight_arguments(jobs[0]), (Texts{"--scenario", "flat", "--set", "effects.haze=0.1", "--set",
                                              "flight.kind=line", "--seed", "7", "--frames", "12"}));
}

TEST(CampaignFile, GroupsAreGridsBesideEachOther) {
  EXPECT_EQ(names_of("[grid]\nseed = 1\n[group far]\nseed = 1 | 2\n[group b]\nscenario = flat\n"),
            (Texts{"seed=1", "far+seed=1", "far+seed=2", "b+flat"}));
}

TEST(CampaignFile, IndentedLineGoesOnWithTheValue) {
  EXPECT_EQ(names_of("[grid]\nscenario = flat |\n   mars-plains\n"), (Texts{"flat", "mars-plains"}));
}

TEST(CampaignFile, NameOfAJobDoesNotDependOnTheOtherJobs) {
  const Texts few = names_of("[grid]\nscenario = flat\nseed = 2\n");
  const Texts many = names_of("[grid]\nscenario = mars-plains | flat\nseed = 1..3\n[group x]\nseed = 4\n");
  EXPECT_EQ(std::count(many.begin(), many.end(), few.at(0)), 1);
}

TEST(CampaignFile, NamesAreDistinctAndFitForFolders) {
  const std::string longest(90, 'x');
  const Texts names = names_of("[grid]\nworld.map = a/b | a_b | a-b | ../..\n | " + longest + "1\n | " + longest +
                               "2 | 'q' $x\n[group p]\nscenario = x_seed=1\n[group p_x]\nseed = 1\n"
                               "[group two]\na.m = 1\nb.m = 1\n[group tricky]\nw.a = 1 | 1_b=2\nw.b = 2 | 2_b=2\n");
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
  for (const std::string& name : names) {
    EXPECT_EQ(name.find_first_of("/ '$\\"), std::string::npos) << name;
    EXPECT_NE(name[0], '.') << name;
    EXPECT_LT(name.size(), 128U);
  }
}

TEST(CampaignFile, ScenarioFileIsFoundBesideTheCampaign) {
  const ScratchFolder folder;
  (void)folder.write("mine.ini", "");
  const auto jobs = expand(read_campaign(folder.write("c.ini", "[grid]\nscenario = mine.ini | flat\n")));
  EXPECT_EQ(jobs.at(0).scenario, (folder / "mine.ini").string());
  EXPECT_EQ(jobs.at(1).scenario, "flat");
}

TEST(CampaignFile, TooManyFlightsAreRefusedBeforeTheyAreMade) {
  EXPECT_EQ(jobs_of("[grid]\nseed = 1..100\nworld.a = 1..100\n").size(), most_jobs);
  const std::string huge =
      "[grid]\nseed = 1..10000\nworld.a = 1..10000\nworld.b = 1..10000\nworld.c = 1..10000\n"
      "world.d = 1..10000\n";
  EXPECT_TRUE(says(refusal(huge), "c.ini:3: with this axis there are more than 10000 flights"));
  EXPECT_TRUE(says(refusal("[grid]\nseed = 1..10000\n[group more]\nseed = 1\n"), "c.ini:4:"));
  EXPECT_TRUE(says(refusal("[grid]\nseed = 0..18446744073709551615\n"), "c.ini:2:"));
}

struct BadFile {
  const char* text;
  const char* message;
};

class BadCampaignFile : public testing::TestWithParam<BadFile> {};

TEST_P(BadCampaignFile, IsNamedWithItsLine) {
  EXPECT_TRUE(says(refusal(GetParam().text), std::string("c.ini") + GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(
    All, BadCampaignFile,
    testing::Values(BadFile{"", ": no flights: expected a section [grid]"},
                    BadFile{"[grid]\nseed = 1\nnonsense\n", ":3: neither a [section]"},
                    BadFile{"[grid\nseed = 1\n", ":1: neither a [section]"},
                    BadFile{"[grid]\nseed = 1\n[gird]\nseed = 1\n", ":4: section [gird]: expected campaign"},
                    BadFile{"[group A/B]\nseed = 1\n", ":2: section [group A/B]"},
                    BadFile{"seed = 1\n", ":1: section []"},
                    BadFile{"[grid]\nseed = 1\n\nseed = 2\n", ":4: [grid] seed stands in line 2 already"},
                    BadFile{"[grid]\nruggedness = 1\n", ":2: [grid] ruggedness: expected scenario, seed, frames or"},
                    BadFile{"[grid]\nseed = 1 | | 2\n", ":2: [grid] seed = 1 | | 2: expected values separated by |"},
                    BadFile{"[grid]\nseed = 1..3 | 2\n", ":2: [grid] seed = 1..3 | 2: expected each value once"},
                    BadFile{"[grid]\nseed = 3..1\n", ":2: [grid] seed = 3..1: expected a range that rises"},
                    BadFile{"[grid]\nseed = -1\n", ":2: [grid] seed = -1: expected whole numbers"},
                    BadFile{"[grid]\nframes = 0\n", ":2: [grid] frames = 0: expected whole numbers from 1"},
                    BadFile{"[grid]\nscenario = no/such.ini\n", ":2: [grid] scenario = no/such.ini: expected a preset"},
                    BadFile{"[campaign]\nframes = many\n", ":2: [campaign] frames = many: expected a whole number"},
                    BadFile{"[campaign]\ntimeout_s = nan\n", ":2: [campaign] timeout_s = nan: expected seconds"},
                    BadFile{"[campaign]\nframe = 3\n", ":2: [campaign] frame: expected name, about, frames"},
                    BadFile{"[campaign]\ncolumns = completness\n",
                            ":2: [campaign] columns = completness: expected a key"},
                    BadFile{"[grid]\nseed = 1\n[set]\nworld.a =\n", ":4: [set] world.a = : expected a value"},
                    BadFile{"[grid]\nseed = 1\n[plot p]\nx = seed\n", ":4: [plot p] expected both x and y"},
                    BadFile{"[grid]\nseed = 1\n[plot p]\nx = world.a\ny = completeness\n", ":4: [plot p] x = world.a"},
                    BadFile{"[grid]\nseed = 1\n[plot p]\ny = height\n", ":4: [plot p] y = height: expected a key"},
                    BadFile{"[grid]\nseed = 1\n[plot p]\nx = seed\ny = completeness\nseries = world.a\n",
                            ":4: [plot p] series = world.a: expected axes"}));

TEST(CampaignFile, WhatTheParserWouldCutIsRefused) {
  EXPECT_TRUE(says(refusal("[grid]\nseed = 1 | " + std::string(300, '2') + "\n"), "c.ini:2: the line is longer than"));
  EXPECT_TRUE(says(refusal("[grid]\nworld." + std::string(60, 'a') + " = 1\n"), "c.ini:2: a name is longer than"));
  EXPECT_TRUE(says(refusal("[plot " + std::string(60, 'a') + "]\nx = 1\n"), "c.ini:1: a name is longer than"));
  EXPECT_TRUE(says(refusal(std::string("[grid]\nseed = 1\0\n", 17)), "c.ini:2: not a text file"));
}

TEST(CampaignFile, MissingFileIsNamed) {
  EXPECT_TRUE(says(test::error_of([] { (void)read_campaign("no/such.ini"); }), "no/such.ini"));
  EXPECT_TRUE(says(test::error_of([] { (void)read_campaign("/tmp"); }), "folder"));
}

// Every file that the project brings can be flown: paths, keys and plots are right.
TEST(CampaignFile, ProvidedCampaignsExpand) {
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator("sim/campaigns")) {
    if (!entry.is_regular_file()) continue;
    ++files;
    const Campaign campaign = read_campaign(entry.path());
    EXPECT_FALSE(expand(campaign).empty()) << entry.path();
    EXPECT_FALSE(campaign.about.empty()) << entry.path();
  }
  EXPECT_GE(files, 5U);
}

}  // namespace
}  // namespace ilp::batch
