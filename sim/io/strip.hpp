// A folder of images as a recorded strip.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace ilp::sim {

struct StripFrame {
  std::int64_t time_ns = 0;
  std::filesystem::path file;
  std::string altitude;  ///< as written in times.txt, may be empty
};

/// The PNG and PGM images of a folder in order of their names, two seconds apart; or, where the folder holds a
/// `times.txt`
/// (`time_ns name [altitude_m]` per line), what that says. std::runtime_error when there are none.
std::vector<StripFrame> list_strip(const std::filesystem::path& folder);

/// The index that the flight's DirectoryCamera reads.
void write_strip_index(const std::filesystem::path& index, const std::vector<StripFrame>& frames);

}  // namespace ilp::sim
