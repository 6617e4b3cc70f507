// The real campaign program with stand-ins for simulator and scorer: parallel, resumable, robust.

#include <algorithm>
#include <csignal>

#include "tests/unit/tools/campaign/campaign_support.hpp"

namespace ilp::test {
namespace {

namespace fs = std::filesystem;
using Texts = std::vector<std::string>;

constexpr const char* two_by_two = "[campaign]\nframes = 5\n[grid]\nscenario = a | b\nseed = 1 | 2\n";

TEST_F(CampaignTest, EveryFlightIsScoredAndOnlyTheBulkIsRemoved) {
  campaign(two_by_two);
  simulator("touch $out/flight.db; mkdir $out/images; echo flying");
  scorer(R"(echo "{\"version\": 1, \"complete\": true, \"summary\": {\"completeness\": 0.$seed}}")");
  ASSERT_EQ(run().status, 0);
  EXPECT_EQ(calls(), (Texts{"a 1 ", "a 2 ", "b 1 ", "b 2 "}));
  EXPECT_EQ(field("b_seed=2", "completeness"), "0.2");
  for (const char* file : {"command.txt", "log.txt", "score.json", "flight-info.json", "result.json"}) {
    EXPECT_TRUE(fs::exists(job("a_seed=1") / file)) << file;
  }
  EXPECT_FALSE(fs::exists(job("a_seed=1") / "run"));
  EXPECT_EQ(text_of(job("a_seed=1") / "log.txt"), "flying\n");
  EXPECT_TRUE(says(text_of(job("a_seed=1") / "command.txt"), "--scenario a --seed 1 --frames 5 --out "));
  for (const char* file : {"table.md", "report.html"}) EXPECT_TRUE(fs::exists(folder / "out" / file)) << file;
}

TEST_F(CampaignTest, KeepLeavesTheFlight) {
  campaign("[grid]\nseed = 1\n");
  ASSERT_EQ(run({"--keep"}).status, 0);
  EXPECT_TRUE(fs::exists(job("seed=1") / "run" / "parameters"));
}

TEST_F(CampaignTest, FinishedFlightsAreNotFlownAgain) {
  campaign(two_by_two);
  ASSERT_EQ(run().status, 0);
  const std::string table = text_of(folder / "out" / "table.csv");
  ASSERT_EQ(run().status, 0);
  EXPECT_EQ(calls().size(), 4U);
  EXPECT_EQ(text_of(folder / "out" / "table.csv"), table);
}

// Killed while one flight is finished and two are in the air.
TEST_F(CampaignTest, KilledCampaignGoesOnWhereItStopped) {
  campaign(two_by_two);
  simulator(R"(echo $$ > "$here/pid$scenario$seed"
if [ "$scenario$seed" != a1 ] && [ ! -e "$here/go" ]; then exec sleep 1000; fi)");
  const pid_t first = start({"--jobs", "2"});
  ASSERT_TRUE(comes_true([&] { return fs::exists(folder / "pida2") && fs::exists(folder / "pidb1"); }));
  kill(first, SIGKILL);
  (void)await(first);
  for (const char* pid : {"pida2", "pidb1"}) {
    const int flight = std::stoi(text_of(folder / pid));
    EXPECT_TRUE(comes_true([&] { return kill(flight, 0) != 0; })) << "a flight has outlived its campaign";
  }
  ASSERT_TRUE(fs::exists(job("a_seed=1") / "result.json"));
  EXPECT_FALSE(fs::exists(job("a_seed=2") / "result.json"));
  (void)folder.write("go", "");
  (void)folder.write("out/jobs/a_seed=2/left-behind", "");
  ASSERT_EQ(run().status, 0);
  EXPECT_EQ(calls(), (Texts{"a 1 ", "a 2 ", "a 2 ", "b 1 ", "b 1 ", "b 2 "}));
  EXPECT_FALSE(fs::exists(job("a_seed=2") / "left-behind"));
}

TEST_F(CampaignTest, InterruptedCampaignLeavesNoProcessAndATable) {
  campaign(two_by_two);
  simulator(R"(sleep 1000 & echo $! > "$here/pid.part"; mv "$here/pid.part" "$here/pid"
if [ "$scenario$seed" != a1 ] && [ ! -e "$here/go" ]; then wait; fi)");
  for (const int signal : {SIGTERM, SIGINT}) {
    fs::remove(folder / "pid");
    fs::remove(folder / "calls");
    fs::remove_all(folder / "out");
    const pid_t program = start({"--jobs", "1"});
    ASSERT_TRUE(comes_true([&] { return calls().size() == 2 && fs::exists(folder / "pid"); }));
    kill(program, signal);
    EXPECT_EQ(await(program).status, 128 + signal);
    const int grandchild = std::stoi(text_of(folder / "pid"));
    EXPECT_TRUE(comes_true([&] { return kill(grandchild, 0) != 0; }));
    EXPECT_EQ(field("a_seed=1", "result"), "done");
    EXPECT_EQ(field("b_seed=2", "result"), "not run");
    EXPECT_TRUE(says(text_of(folder / "messages"), "goes on where this one stopped"));
  }
  (void)folder.write("go", "");
  ASSERT_EQ(run().status, 0);
  EXPECT_EQ(calls(), (Texts{"a 1 ", "a 2 ", "a 2 ", "b 1 ", "b 2 "}));
}

TEST_F(CampaignTest, ChangedParametersProgramsAndScenariosAreFlownAgain) {
  (void)folder.write("mine.ini", "one");
  campaign("[grid]\nscenario = a | mine.ini\nseed = 1\n[set]\nworld.x = 1\n");
  ASSERT_EQ(run().status, 0);
  const auto fresh_calls = [&] {
    fs::remove(folder / "calls");
    EXPECT_EQ(run().status, 0);
    return calls().size();
  };
  campaign(
      "[campaign]\ntimeout_s = 77\n[grid]\nscenario = a | mine.ini | b\nseed = 1\n[set]\nworld.x = 1\n"
      "[plot p]\nx = seed\ny = completeness\n");
  EXPECT_EQ(fresh_calls(), 1U) << "only what is new: limits and plots change no number";
  (void)folder.write("mine.ini", "two");
  EXPECT_EQ(fresh_calls(), 1U) << "the one with the scenario file";
  campaign("[grid]\nscenario = a | mine.ini | b\nseed = 1\n[set]\nworld.x = 2\n");
  EXPECT_EQ(fresh_calls(), 3U);
  scorer(R"(echo '{"version": 1, "complete": true, "summary": {"completeness": 0.25}}')");
  EXPECT_EQ(fresh_calls(), 3U);
  EXPECT_EQ(field("a_seed=1", "completeness"), "0.25");
}

TEST_F(CampaignTest, DamagedResultIsNotBelieved) {
  campaign("[grid]\nseed = 1 | 2\n");
  ASSERT_EQ(run().status, 0);
  const std::string whole = text_of(job("seed=1") / "result.json");
  for (const std::size_t length : {std::size_t{0}, whole.size() / 2}) {
    (void)folder.write("out/jobs/seed=1/result.json", whole.substr(0, length));
    fs::remove(folder / "calls");
    ASSERT_EQ(run().status, 0);
    EXPECT_EQ(calls(), Texts{" 1 "});
  }
}

TEST_F(CampaignTest, FailuresAreNamedAndStopNobody) {
  campaign(
      "[campaign]\ntimeout_s = 3\n[grid]\nscenario = fine | crash | status | hang | nothing | garbage | list | "
      "text | version\n[group late]\nscenario = crash | hang | fine\n");
  simulator(R"(case $scenario in
  crash) [[ $out = *late* ]] || { echo 'about to <crash>'; kill -SEGV $$; } ;;
  status) echo 'first'; echo 'too low'; exit 4 ;;
  hang) [[ $out = *late* ]] || { sleep 1000 & echo $! > "$here/pid"; wait; } ;;
esac)");
  scorer(R"(case $scenario in
  crash) kill -ABRT $$ ;;
  hang) sleep 1000 ;;
  nothing) rm $run/score.json ;;
  garbage) echo '{"version": 1, "complete"' ;;
  list) echo '[]' ;;
  text) echo '{"version": 1, "complete": true, "summary": {"completeness": "high"}}' ;;
  version) echo '{"version": 2, "complete": true, "summary": {}}' ;;
  *) echo '{"version": 1, "complete": false, "summary": {"completeness": null}, "remarks": ["so so"]}' ;;
esac)");
  const CampaignEnd end = run({"--jobs", "4"});
  EXPECT_EQ(end.status, 1);
  EXPECT_TRUE(says(end.messages, "failed: status: sil ended with status 4: too low"));
  EXPECT_TRUE(says(end.messages, "10 of 12 flights failed"));
  const auto failure = [&](const std::string& name) { return field(name, "failure"); };
  EXPECT_EQ(failure("crash"), "sil killed by signal 11 (Segmentation fault)");
  EXPECT_EQ(failure("late+crash"), "score killed by signal 6 (Aborted)");
  EXPECT_EQ(failure("hang"), "sil ran past the limit of 3.0 s");
  EXPECT_EQ(failure("late+hang"), "score ran past the limit of 3.0 s");
  EXPECT_EQ(failure("nothing"), "score left a bad score: no score.json");
  EXPECT_EQ(failure("garbage"), "score left a bad score: score.json is not JSON");
  EXPECT_EQ(failure("list"), "score left a bad score: score.json is not a JSON object");
  EXPECT_TRUE(says(failure("text"), "number or null"));
  EXPECT_TRUE(says(failure("version"), "1"));
  EXPECT_EQ(field("late+fine", "result"), "done");
  EXPECT_EQ(field("fine", "complete"), "false");
  const int grandchild = std::stoi(text_of(folder / "pid"));
  EXPECT_TRUE(comes_true([&] { return kill(grandchild, 0) != 0; })) << "the time limit ends the whole group";
  EXPECT_TRUE(says(text_of(folder / "out" / "report.html"), "about to &lt;crash&gt;"));
  EXPECT_TRUE(fs::exists(job("status") / "run")) << "left for inspection";
}

TEST_F(CampaignTest, FailuresAreFlownAgainOnRequestOnly) {
  campaign("[grid]\nseed = 1 | 2\n");
  simulator("[ $seed = 1 ] || [ -e $here/go ] || exit 4");
  EXPECT_EQ(run().status, 1);
  EXPECT_EQ(run().status, 1);
  EXPECT_EQ(calls().size(), 2U);
  (void)folder.write("go", "");
  EXPECT_EQ(run({"--retry-failed"}).status, 0);
  EXPECT_EQ(calls(), (Texts{" 1 ", " 2 ", " 2 "}));
}

// Somebody who ends a flight, or the machine that goes down, says nothing about the flight.
TEST_F(CampaignTest, FlightEndedFromOutsideIsFlownAgain) {
  campaign("[grid]\nseed = 1\n");
  simulator("[ -e $here/go ] || kill -TERM $$");
  EXPECT_EQ(run().status, 1);
  (void)folder.write("go", "");
  EXPECT_EQ(run().status, 0);
}

// The first flight ends last, and the processes are as many as allowed or one.
TEST_F(CampaignTest, TablesDoNotDependOnTheOrderOfFinishing) {
  campaign("[campaign]\ncolumns = completeness\n[grid]\nscenario = a | b\nseed = 1..3\n");
  scorer(R"(echo "{\"version\": 1, \"complete\": true, \"summary\": {\"completeness\": 0.$seed}}")");
  simulator(R"([ ! -e "$here/wait" ] || [ "$scenario$seed" != a1 ] || until [ -e "$here/b3" ]; do
  sleep 0.01
done
touch "$here/$scenario$seed")");
  (void)folder.write("wait", "");
  ASSERT_EQ(run({"--jobs", "3"}).status, 0);
  EXPECT_EQ(lines_of(folder / "calls").size(), 6U);
  EXPECT_EQ(field("a_seed=1", "completeness"), "0.1");
  EXPECT_EQ(field("b_seed=3", "completeness"), "0.3");
  std::vector<std::string> files;
  for (const char* name : {"table.csv", "table.md", "report.html"}) files.push_back(text_of(folder / "out" / name));
  fs::remove_all(folder / "out");
  ASSERT_EQ(run({"--jobs", "1"}).status, 0);
  EXPECT_EQ(text_of(folder / "out" / "table.csv"), files[0]);
  EXPECT_EQ(text_of(folder / "out" / "table.md"), files[1]);
  EXPECT_EQ(text_of(folder / "out" / "report.html"), files[2]);
  EXPECT_TRUE(says(files[1], "| a | 3 | 0.200 (0.100) |"));
}

TEST_F(CampaignTest, FlightsInheritNothing) {
  campaign("[grid]\nseed = 1\n");
  simulator(
      "ls -l /proc/$$/fd | grep -c /messages; env | grep -c SECRET; cat | wc -c; "
      "grep -E '^Sig(Blk|Ign)' /proc/$$/status | tr -d '\\t'; ulimit -c");
  setenv("SECRET", "x", 1);
  ASSERT_EQ(run().status, 0);
  unsetenv("SECRET");
  const Texts lines = lines_of(job("seed=1") / "log.txt");
  ASSERT_EQ(lines.size(), 6U);
  EXPECT_EQ(lines[0], "0");
  EXPECT_EQ(lines[1], "0");
  EXPECT_EQ(lines[2], "0");
  EXPECT_EQ(lines[5], "0");
}

TEST_F(CampaignTest, FolderOfSomebodyElseIsLeftAlone) {
  campaign("[campaign]\nname = one\n[grid]\nseed = 1\n");
  fs::create_directories(folder / "out");
  (void)folder.write("out/thesis.tex", "years");
  CampaignEnd end = run();
  EXPECT_EQ(end.status, 2);
  EXPECT_TRUE(says(end.messages, "holds other things"));
  fs::remove(folder / "out" / "thesis.tex");
  EXPECT_EQ(run().status, 0);
  campaign("[campaign]\nname = two\n[grid]\nseed = 1\n");
  end = run();
  EXPECT_EQ(end.status, 2);
  EXPECT_TRUE(says(end.messages, "holds the campaign \"one\", not \"two\""));
}

TEST_F(CampaignTest, TwoRunsDoNotShareAFolder) {
  campaign("[grid]\nseed = 1\n");
  simulator(R"(until [ -e "$here/go" ]; do sleep 0.01; done)");
  const pid_t first = start();
  EXPECT_TRUE(comes_true([&] { return calls().size() == 1; }));
  const CampaignEnd second = run();
  EXPECT_EQ(second.status, 2);
  EXPECT_TRUE(says(second.messages, "another run of this campaign works in"));
  (void)folder.write("go", "");
  EXPECT_EQ(await(first).status, 0);
}

TEST_F(CampaignTest, BadCallsAreExplained) {
  campaign("[grid]\nseed = 1\n");
  EXPECT_TRUE(says(run({"--sil", "/no/such"}).messages, "there is no program /no/such"));
  (void)folder.write("text", "no program");
  fs::remove_all(folder / "out");
  CampaignEnd end = run({"--score", folder / "text"});
  EXPECT_EQ(end.status, 1);
  EXPECT_TRUE(says(end.messages, "cannot start"));
  end = run({"--jobs", "0"});
  EXPECT_EQ(end.status, 2);
  campaign("[grid]\nseed = x\n");
  end = run();
  EXPECT_EQ(end.status, 2);
  EXPECT_TRUE(says(end.messages, "c.ini:2: [grid] seed = x"));
}

}  // namespace
}  // namespace ilp::test
