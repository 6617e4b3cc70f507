#include "sim/io/strip.hpp"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace ilp::sim {
namespace fs = std::filesystem;
namespace {

constexpr std::int64_t default_interval_ns = 2'000'000'000;

std::vector<StripFrame> read_times(const fs::path& times) {
  std::ifstream in(times);
  std::vector<StripFrame> frames;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    std::istringstream words(line);
    std::string first;
    if (!(words >> first) || first[0] == '#') continue;
    StripFrame frame;
    std::string name;
    std::istringstream time(first);
    if (!(time >> frame.time_ns) || !time.eof() || !(words >> name)) {
      throw std::runtime_error(times.string() + ", line " + std::to_string(number) +
                               ": expected time_ns name [altitude_m]");
    }
    words >> frame.altitude;
    frame.file = times.parent_path() / name;
    frames.push_back(frame);
  }
  return frames;
}

bool is_image(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension == ".png" || extension == ".pgm";
}

}  // namespace

std::vector<StripFrame> list_strip(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw std::runtime_error(folder.string() + " is not a folder of images");
  // A strip as this project's data come: images/ beside the camera file.
  const fs::path images =
      fs::is_directory(folder / "images") && !fs::exists(folder / "times.txt") ? folder / "images" : folder;
  std::vector<StripFrame> frames;
  if (fs::exists(images / "times.txt")) {
    frames = read_times(images / "times.txt");
  } else {
    for (const auto& entry : fs::directory_iterator(images)) {
      if (entry.is_regular_file() && is_image(entry.path())) frames.push_back({0, entry.path(), {}});
    }
    std::sort(frames.begin(), frames.end(), [](const StripFrame& a, const StripFrame& b) { return a.file < b.file; });
    for (std::size_t i = 0; i < frames.size(); ++i)
      frames[i].time_ns = static_cast<std::int64_t>(i) * default_interval_ns;
  }
  if (frames.empty()) throw std::runtime_error(images.string() + " holds no PNG or PGM image");
  return frames;
}

void write_strip_index(const fs::path& index, const std::vector<StripFrame>& frames) {
  std::ofstream out(index);
  out << "# time_ns file [altitude_m]\n";
  for (const StripFrame& frame : frames) {
    const std::string file = fs::absolute(frame.file).string();
    if (file.find(' ') != std::string::npos) {
      throw std::runtime_error("'" + file + "': blanks in the path of an image are not supported");
    }
    out << frame.time_ns << " " << file << (frame.altitude.empty() ? "" : " " + frame.altitude) << "\n";
  }
  if (!out.flush()) throw std::runtime_error(index.string() + " cannot be written");
}

}  // namespace ilp::sim
