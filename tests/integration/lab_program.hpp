// Runs the real ilp-lab and holds what it said.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "fsw/base/image_view.hpp"

namespace ilp::test {

struct LabRun {
  int status = -1;  ///< exit status, or -1 when a signal ended it
  std::string out, err;
  nlohmann::json json;  ///< of standard output; a discarded value, which throws on access, when that is no JSON

  [[nodiscard]] double number(const char* name) const { return json.at(name).get<double>(); }
  [[nodiscard]] std::string verdict() const { return json.at("verdict").get<std::string>(); }
};

/// Every test has an empty folder of its own and runs the program with arguments in it.
class LabTest : public ::testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;

  [[nodiscard]] LabRun lab(const std::string& arguments) const;
  /// The test fails where the program does not end with status 0.
  LabRun lab_done(const std::string& arguments) const;
  [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string write(const std::string& name, const std::string& text) const;
  /// A file of the shared data, or empty when the data are absent.
  [[nodiscard]] static std::string shared(const std::string& name);
  /// Numbers of a text file, line by line, without comments and empty lines.
  [[nodiscard]] static std::vector<std::vector<double>> read_numbers(const std::string& file);

 private:
  std::filesystem::path folder_;
};

/// COLMAP's cameras.txt with one PINHOLE camera whose centres are at integers.
[[nodiscard]] std::string pinhole_text(int width, int height, double focal, double cx, double cy);

}  // namespace ilp::test
