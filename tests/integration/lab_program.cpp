#include "tests/integration/lab_program.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "tests/support/read_image.hpp"

namespace ilp::test {
namespace fs = std::filesystem;
namespace {

std::string content(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

}  // namespace

void LabTest::SetUp() {
  std::string name = (fs::temp_directory_path() / "ilp-lab-test-XXXXXX").string();
  ASSERT_NE(mkdtemp(name.data()), nullptr);
  folder_ = name;
}

void LabTest::TearDown() {
  std::error_code ignored;
  if (!folder_.empty()) fs::remove_all(folder_, ignored);
}

LabRun LabTest::lab(const std::string& arguments) const {
  const std::string command =
      std::string(ILP_LAB_PROGRAM) + " " + arguments + " >" + path("stdout") + " 2>" + path("stderr") + " </dev/null";
  const int ended = std::system(command.c_str());
  LabRun run{.status = WIFEXITED(ended) ? WEXITSTATUS(ended) : -1};
  // The shell's way to say that a signal ended the program.
  if (run.status > 128) run.status = -1;
  run.out = content(path("stdout"));
  run.err = content(path("stderr"));
  run.json = nlohmann::json::parse(run.out, nullptr, false);
  return run;
}

LabRun LabTest::lab_done(const std::string& arguments) const {
  LabRun run = lab(arguments);
  EXPECT_EQ(run.status, 0) << run.err;
  return run;
}

std::string LabTest::write(const std::string& name, const std::string& text) const {
  std::ofstream(path(name), std::ios::binary) << text;
  return path(name);
}

std::string LabTest::shared(const std::string& name) {
  const std::string file = data_root + name;
  return fs::exists(file) ? file : "";
}

std::vector<std::vector<double>> LabTest::read_numbers(const std::string& file) {
  std::ifstream in(file);
  std::vector<std::vector<double>> lines;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    lines.emplace_back();
    for (double value = 0; words >> value;) lines.back().push_back(value);
  }
  return lines;
}

std::string pinhole_text(int width, int height, double focal, double cx, double cy) {
  std::ostringstream text;
  text.precision(17);
  text << "1 PINHOLE " << width << " " << height << " " << focal << " " << focal << " " << cx + 0.5 << " " << cy + 0.5
       << "\n";
  return text.str();
}

}  // namespace ilp::test
