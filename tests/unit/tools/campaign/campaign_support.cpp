#include "tests/unit/tools/campaign/campaign_support.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <sstream>
#include <thread>

namespace ilp::test {
namespace fs = std::filesystem;

CampaignTest::CampaignTest() {
  simulator("");
  scorer(R"(echo '{"version": 1, "complete": true, "summary": {"completeness": 0.5}}')");
}

void CampaignTest::simulator(const std::string& body) const {
  const fs::path script = folder.write("sil", "#!/bin/bash\nhere=" + folder.path().string() + R"(
while [ $# -gt 0 ]; do
  case $1 in --out) out=$2 ;; --seed) seed=$2 ;; --set) set=$2 ;; --scenario) scenario=$2 ;; esac
  shift 2
done
mkdir "$out" || exit 9
echo "$scenario $seed $set" >> "$here/calls"
echo "$scenario $seed $set" > "$out/parameters"
echo '{}' > "$out/flight-info.json"
)" + body + "\n");
  fs::permissions(script, fs::perms::owner_all);
}

void CampaignTest::scorer(const std::string& body) const {
  const fs::path script = folder.write(
      "score", "#!/bin/bash\nrun=$1\nread scenario seed set < $run/parameters\n{\n" + body + "\n} > $run/score.json\n");
  fs::permissions(script, fs::perms::owner_all);
}

std::vector<std::string> CampaignTest::command(const std::vector<std::string>& more) const {
  std::vector<std::string> words{ILP_CAMPAIGN_PROGRAM, folder / "c.ini", "--out",         folder / "out", "--sil",
                                 folder / "sil",       "--score",        folder / "score"};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

pid_t CampaignTest::start(const std::vector<std::string>& more) const {
  std::vector<std::string> words = command(more);
  std::vector<char*> pointers;
  pointers.reserve(words.size() + 1);
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const std::string log = folder / "messages";
  const pid_t child = fork();
  if (child != 0) return child;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const int file = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  dup2(file, STDOUT_FILENO);
  dup2(file, STDERR_FILENO);
  // What the campaign must not hand on: an open file, and leave to write core files.
  dup2(file, 50);
  rlimit core{};
  getrlimit(RLIMIT_CORE, &core);
  core.rlim_cur = core.rlim_max;
  setrlimit(RLIMIT_CORE, &core);
  execv(pointers[0], pointers.data());
  _exit(127);
}

CampaignEnd CampaignTest::await(pid_t program) {
  CampaignEnd end;
  int status = 0;
  waitpid(program, &status, 0);
  if (WIFEXITED(status)) end.status = WEXITSTATUS(status);
  return end;
}

CampaignEnd CampaignTest::run(const std::vector<std::string>& more) const {
  CampaignEnd end = await(start(more));
  end.messages = text_of(folder / "messages");
  return end;
}

std::vector<std::string> CampaignTest::calls() const {
  std::vector<std::string> lines = lines_of(folder / "calls");
  std::sort(lines.begin(), lines.end());
  return lines;
}

std::string CampaignTest::field(const std::string& job, const std::string& column) const {
  const auto split = [](const std::string& line) {
    std::vector<std::string> fields;
    std::istringstream in(line + ",");
    for (std::string one; std::getline(in, one, ',');) fields.push_back(one);
    return fields;
  };
  const std::vector<std::string> lines = lines_of(folder / "out" / "table.csv");
  if (lines.empty()) return "no table";
  const std::vector<std::string> header = split(lines[0]);
  const auto place = std::find(header.begin(), header.end(), column);
  if (place == header.end()) return "no column";
  for (const std::string& line : lines) {
    const std::vector<std::string> fields = split(line);
    if (fields[0] == job) return fields[static_cast<std::size_t>(place - header.begin())];
  }
  return "no job";
}

bool comes_true(const std::function<bool()>& condition) {
  for (int i = 0; i < 3000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

std::vector<std::string> lines_of(const fs::path& file) {
  std::ifstream in(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

}  // namespace ilp::test
