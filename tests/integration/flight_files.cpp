#include "tests/integration/flight_files.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <sstream>
#include <thread>

#include "sim/host/colmap.hpp"

namespace ilp::test {
namespace fs = std::filesystem;
namespace {

/// Both outputs go to `output`.
pid_t start(const std::vector<std::string>& arguments, const fs::path& input, int output) {
  std::vector<char*> words;
  for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
  words.push_back(nullptr);
  const pid_t child = fork();
  if (child != 0) return child;
  // A flight that never ends must not outlive the test that ran into its time limit.
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const int in = open(input.empty() ? "/dev/null" : input.c_str(), O_RDONLY);
  dup2(in, STDIN_FILENO);
  dup2(output, STDOUT_FILENO);
  dup2(output, STDERR_FILENO);
  execv(words[0], words.data());
  _exit(127);
}

}  // namespace

fs::path prepared_flights() {
  return ILP_PREPARED_FLIGHTS;
}

std::string camera_numbers(const fs::path& flight) {
  const CameraModel c = host::read_colmap_camera(flight / "cameras.txt");
  std::ostringstream text;
  text.precision(17);
  text << c.width << " " << c.height << " " << c.fx << " " << c.fy << " " << c.cx << " " << c.cy;
  return text.str();
}

ProgramResult run_well(const std::vector<std::string>& arguments, const fs::path& input) {
  ProgramResult result = run_program(arguments, input);
  EXPECT_EQ(result.exit_status, 0) << result.output;
  return result;
}

ProgramResult run_program(const std::vector<std::string>& arguments, const fs::path& input) {
  ProgramResult result;
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return result;
  const pid_t child = start(arguments, input, ends[1]);
  close(ends[1]);
  char buffer[4096];
  for (ssize_t n = 0; (n = read(ends[0], buffer, sizeof(buffer))) > 0;) {
    result.output.append(buffer, static_cast<std::size_t>(n));
  }
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (WIFEXITED(status)) result.exit_status = WEXITSTATUS(status);
  return result;
}

bool run_and_kill(const std::vector<std::string>& arguments, int after_ms) {
  const int null = open("/dev/null", O_WRONLY | O_CLOEXEC);
  const pid_t child = start(arguments, {}, null);
  close(null);
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(after_ms);
  int status = 0;
  while (std::chrono::steady_clock::now() < end) {
    if (waitpid(child, &status, WNOHANG) == child) return WIFEXITED(status) && WEXITSTATUS(status) == 0;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  kill(child, SIGKILL);
  waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

std::vector<std::string> sil_command(const fs::path& flight, const fs::path& out,
                                     const std::vector<std::string>& more) {
  std::vector<std::string> command{ILP_SIL, "--images",  flight.string(), "--camera", (flight / "cameras.txt").string(),
                                   "--out", out.string()};
  command.insert(command.end(), more.begin(), more.end());
  return command;
}

Bytes read_file(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return Bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
}

void write_file(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

void write_private_file(const fs::path& path, const std::string& text) {
  write_file(path, text);
  fs::permissions(path, fs::perms::owner_read | fs::perms::owner_write);
}

std::map<std::string, Bytes> files_of(const fs::path& folder, const std::vector<std::string>& prefixes) {
  std::map<std::string, Bytes> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    const bool wanted = std::any_of(prefixes.begin(), prefixes.end(),
                                    [&](const std::string& prefix) { return name.rfind(prefix, 0) == 0; });
    if (wanted) files[name] = read_file(entry.path());
  }
  return files;
}

std::map<std::string, Bytes> results_of(const fs::path& out) {
  return files_of(out / "outbox", {"product-", "records-"});
}

void expect_same_files(const std::map<std::string, Bytes>& a, const std::map<std::string, Bytes>& b) {
  for (const auto& [name, bytes] : a) {
    const auto other = b.find(name);
    if (other == b.end()) {
      ADD_FAILURE() << name << " is missing";
      continue;
    }
    const auto differ = std::mismatch(bytes.begin(), bytes.end(), other->second.begin(), other->second.end());
    if (differ.first != bytes.end() || differ.second != other->second.end()) {
      ADD_FAILURE() << name << " differs at byte " << differ.first - bytes.begin() << ", sizes " << bytes.size()
                    << " and " << other->second.size();
    }
  }
  for (const auto& entry : b) EXPECT_EQ(a.count(entry.first), 1U) << entry.first << " is one too many";
}

std::size_t events_of(const fs::path& out, StatusCode code) {
  const std::vector<EventRecord> events = records_of<EventRecord>(out);
  return static_cast<std::size_t>(std::count_if(events.begin(), events.end(), [code](const EventRecord& event) {
    return event.code == static_cast<std::uint16_t>(code);
  }));
}

OwnFlight::OwnFlight(fs::path folder) : folder_(std::move(folder)) {
  fs::create_directories(folder_);
  const fs::path plain = prepared_flights() / "plain";
  fs::copy(plain / "images", folder_ / "images");
  fs::copy(plain / "index.txt", folder_ / "index.txt");
  fs::copy(plain / "cameras.txt", folder_ / "cameras.txt");
}

namespace {
std::string image_name(int number) {
  char name[32];
  std::snprintf(name, sizeof(name), "images/%04d.pgm", number);
  return name;
}
}  // namespace

host::Raster<std::uint8_t> OwnFlight::frame(int number) const {
  return host::read_gray(folder_ / image_name(number));
}

void OwnFlight::replace(int number, const host::Raster<std::uint8_t>& image) const {
  host::write_pgm(folder_ / image_name(number), image.view());
}

void OwnFlight::keep(const std::vector<int>& numbers) const {
  std::string index;
  for (const int number : numbers) {
    index += std::to_string(4'000'000'000LL * (number - 1)) + " " + image_name(number) + "\n";
  }
  write_file(folder_ / "index.txt", index);
}

void OwnFlight::come_back() const {
  std::string index;
  std::int64_t time_ns = 0;
  for (const int number : {1, 2, 3, 4, 5, 6, 7, 8, 9, 17, 18, 19, 20, 2, 3, 4, 5, 6, 7, 8}) {
    index += std::to_string(time_ns) + " " + image_name(number) + "\n";
    time_ns += 4'000'000'000;
  }
  write_file(folder_ / "index.txt", index);
}

}  // namespace ilp::test
