#include "sim/tools/campaign/job_run.hpp"

#include <algorithm>
#include <cctype>
#include <csignal>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

#include "sim/host/files.hpp"
#include "sim/host/text_format.hpp"
#include "sim/tools/campaign/child_process.hpp"

namespace ilp::batch {
namespace fs = std::filesystem;
namespace {

std::string shell_words(const std::vector<std::string>& command) {
  constexpr const char* plain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-+=/:,@%";
  std::string line;
  for (const std::string& word : command) {
    if (!line.empty()) line += ' ';
    if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) {
      line += word;
      continue;
    }
    line += '\'';
    for (const char c : word) line += c == '\'' ? std::string("'\\''") : std::string(1, c);
    line += '\'';
  }
  return line;
}

void remove_folder(const fs::path& folder) {
  std::error_code error;
  // Programs of a campaign that was killed may need a moment to die, and write meanwhile.
  for (int attempt = 0; attempt < 20; ++attempt) {
    fs::remove_all(folder, error);
    if (!error) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  throw std::runtime_error("cannot remove " + folder.string() + ": " + error.message());
}

/// What a program that gives up says at last; as plain text.
std::string last_line(const fs::path& log) {
  std::string text = tail_of(log, 1000);
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())) != 0) text.pop_back();
  text.erase(0, text.rfind('\n') + 1);
  for (char& c : text) c = c < 0x20 || c > 0x7e ? '?' : c;
  return text.substr(0, 400);
}

/// The machine shuts down, or somebody ran out of patience or memory: no property of the flight.
bool ended_from_outside(const ProgramEnd& end) {
  return end.signal == SIGTERM || end.signal == SIGINT || end.signal == SIGHUP || end.signal == SIGKILL;
}

}  // namespace

JobRun::JobRun(const Job& job, fs::path folder, const JobPrograms& programs, std::string digest)
    : folder_(std::move(folder)), programs_(&programs), digest_(std::move(digest)), begin_(Clock::now()) {
  deadline_ = begin_ + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(programs.timeout_s));
  remove_folder(folder_);
  fs::create_directories(folder_);
  std::vector<std::string> command{programs.sil.string()};
  for (std::string& argument : flight_arguments(job)) command.push_back(std::move(argument));
  command.insert(command.end(), {"--out", (folder_ / "run").string(), "--threads", std::to_string(programs.threads)});
  ground::write_file(
      folder_ / "command.txt",
      shell_words(command) + "\n" + shell_words({programs.score.string(), (folder_ / "run").string()}) + "\n");
  try {
    process_ = start_program({command, programs.folder, folder_ / "log.txt"});
  } catch (const std::runtime_error& error) {
    start_fault_ = error.what();
    deadline_ = begin_;
  }
  stage_ = Stage::flight;
}

JobRun::~JobRun() {
  if (process_ > 0) kill_program(process_);
}

JobRun::JobRun(JobRun&& other) noexcept
    : folder_(std::move(other.folder_)),
      programs_(other.programs_),
      digest_(std::move(other.digest_)),
      begin_(other.begin_),
      deadline_(other.deadline_),
      stage_(std::exchange(other.stage_, Stage::over)),
      process_(std::exchange(other.process_, 0)),
      start_fault_(std::move(other.start_fault_)) {}

std::optional<JobResult> JobRun::step() {
  if (stage_ == Stage::over) throw std::logic_error("a job that is over has no further step");
  if (!start_fault_.empty()) return fail(start_fault_);
  const std::string program = (stage_ == Stage::flight ? programs_->sil : programs_->score).filename().string();
  const std::optional<ProgramEnd> end = program_end(process_);
  if (!end) {
    if (Clock::now() < deadline_) return {};
    kill_program(std::exchange(process_, 0));
    return fail(program + " ran past the limit of " + ground::duration_text(programs_->timeout_s));
  }
  process_ = 0;
  if (ended_from_outside(*end)) digest_.clear();
  if (const std::string fault = fault_of(*end); !fault.empty()) {
    const std::string reason = end->status == 0 ? "" : last_line(folder_ / "log.txt");
    return fail(program + " " + fault + (reason.empty() ? "" : ": ") + reason);
  }
  if (stage_ == Stage::score) return collect();
  try {
    process_ = start_program(
        {{programs_->score.string(), (folder_ / "run").string()}, programs_->folder, folder_ / "log.txt"});
  } catch (const std::runtime_error& error) {
    return fail(error.what());
  }
  stage_ = Stage::score;
  return {};
}

JobResult JobRun::collect() {
  JobResult result;
  try {
    result.score = read_score(folder_ / "run" / "score.json");
  } catch (const std::runtime_error& error) {
    return fail(programs_->score.filename().string() + " left a bad score: " + error.what());
  }
  for (const char* name : {"score.json", "flight-info.json"}) {
    std::error_code missing;
    fs::copy_file(folder_ / "run" / name, folder_ / name, fs::copy_options::overwrite_existing, missing);
  }
  if (!programs_->keep) remove_folder(folder_ / "run");
  return finish(std::move(result));
}

JobResult JobRun::fail(const std::string& failure) {
  JobResult result;
  result.failure = failure;
  return finish(std::move(result));
}

JobResult JobRun::finish(JobResult result) {
  stage_ = Stage::over;
  result.digest = digest_;
  result.seconds = std::chrono::duration<double>(Clock::now() - begin_).count();
  write_result(folder_ / "result.json", result);
  return result;
}

std::string tail_of(const fs::path& file, std::size_t bytes) {
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in) return {};
  const auto size = static_cast<std::size_t>(in.tellg());
  const std::size_t wanted = std::min(size, bytes);
  std::string text(wanted, '\0');
  in.seekg(static_cast<std::streamoff>(size - wanted));
  in.read(text.data(), static_cast<std::streamsize>(wanted));
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (wanted < size) text.erase(0, text.find('\n') + 1);
  return text;
}

}  // namespace ilp::batch
