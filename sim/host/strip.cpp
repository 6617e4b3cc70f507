#include "sim/host/strip.hpp"
#include "sim/host/files.hpp"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>

#include "cfg/limits.hpp"
#include "sim/host/image_io.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::host {
namespace fs = std::filesystem;
namespace {

constexpr std::int64_t default_interval_ns = 2'000'000'000;

// As DirectoryCamera reads it: digits with an optional point, no exponent.
bool is_decimal(const std::string& word) {
  double value = 0;
  const char* const end = word.data() + word.size();
  const auto [rest, error] = std::from_chars(word.data(), end, value, std::chars_format::fixed);
  return error == std::errc() && rest == end && std::isfinite(value) && word.size() <= 15;
}

bool is_time(const std::string& word, std::int64_t& time_ns) {
  const char* const end = word.data() + word.size();
  const auto [rest, error] = std::from_chars(word.data(), end, time_ns);
  return error == std::errc() && rest == end && word.size() <= 18;
}

std::vector<StripFrame> read_list(const fs::path& list) {
  std::ifstream in(list);
  if (!in) throw std::runtime_error(list.string() + " cannot be read");
  std::vector<StripFrame> frames;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    std::istringstream text(line);
    std::vector<std::string> words;
    for (std::string word; text >> word;) words.push_back(word);
    if (words.empty() || words[0][0] == '#') continue;
    StripFrame frame;
    const bool good = is_time(words[0], frame.time_ns) && (words.size() == 2 || words.size() == 3) &&
                      (words.size() < 3 || is_decimal(words[2]));
    if (!good) {
      throw std::runtime_error(list.string() + ", line " + std::to_string(number) +
                               ": expected time_ns name [altitude_m], found '" + line.substr(0, 80) + "'");
    }
    frame.file = list.parent_path() / words[1];
    if (words.size() == 3) frame.altitude = words[2];
    frames.push_back(frame);
  }
  return frames;
}

bool is_image(const fs::path& path) {
  // Such files accompany others, as those of macOS on a memory card.
  if (path.filename().string().starts_with(".")) return false;
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  constexpr const char* known[] = {".png", ".pgm", ".jpg", ".jpeg", ".tif", ".tiff"};
  return std::find(std::begin(known), std::end(known), extension) != std::end(known);
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// Digits from `at` on, without leading zeros; `at` moves behind them.
std::string number_at(const std::string& text, std::size_t& at) {
  const std::size_t begin = at;
  while (at < text.size() && is_digit(text[at])) ++at;
  const std::size_t first = std::min(text.find_first_not_of('0', begin), at);
  return text.substr(first, at - first);
}

/// img_2 stands before img_10.
bool natural_order(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      const std::string first = number_at(a, i), second = number_at(b, j);
      if (first.size() != second.size()) return first.size() < second.size();
      if (first != second) return first < second;
    } else if (a[i] != b[j]) {
      return a[i] < b[j];
    } else {
      ++i;
      ++j;
    }
  }
  if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
  return a < b;
}

fs::path list_in(const fs::path& folder) {
  for (const char* name : {"times.txt", "frames.txt", "index.txt"}) {
    if (fs::exists(folder / name)) return folder / name;
  }
  return {};
}

std::vector<StripFrame> frames_in(const fs::path& folder) {
  if (const fs::path list = list_in(folder); !list.empty()) return read_list(list);
  std::vector<StripFrame> frames;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.is_regular_file() && is_image(entry.path())) frames.push_back({0, entry.path(), {}, true});
  }
  std::sort(frames.begin(), frames.end(), [](const StripFrame& a, const StripFrame& b) {
    return natural_order(a.file.filename().string(), b.file.filename().string());
  });
  for (std::size_t i = 0; i < frames.size(); ++i)
    frames[i].time_ns = static_cast<std::int64_t>(i) * default_interval_ns;
  return frames;
}

}  // namespace

std::vector<StripFrame> list_strip(const fs::path& folder) {
  if (!fs::is_directory(folder))
    throw std::runtime_error(folder.string() + " is not a folder of images: check the path");
  std::vector<StripFrame> frames = frames_in(folder);
  if (list_in(folder).empty() && fs::is_directory(folder / "images")) {
    // A stray picture beside the folder of the images is no strip.
    std::vector<StripFrame> inside = frames_in(folder / "images");
    if (inside.size() > frames.size() || !list_in(folder / "images").empty()) frames = std::move(inside);
  }
  if (frames.empty())
    throw std::runtime_error(folder.string() +
                             " holds no image: name a folder with PNG, PGM, JPEG or TIFF files, or with a times.txt");
  return frames;
}

std::vector<std::string> strip_warnings(const std::vector<StripFrame>& frames, const fs::path& folder) {
  std::vector<std::string> warnings;
  if (frames.size() > 1 && frames.front().time_is_assumed) {
    warnings.push_back(
        (folder.empty() ? frames.front().file.parent_path() : folder).string() +
        " has no times.txt: the images are taken as two seconds apart, in the order of their names, numbers by "
        "their value");
  }
  ImageSize first;
  std::string first_name;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const StripFrame& frame = frames[i];
    if (i > 0 && frame.time_ns <= frames[i - 1].time_ns) {
      warnings.push_back(frame.file.string() + " is not later than the frame before it");
    }
    ImageSize size;
    try {
      size = read_image_size(frame.file);
    } catch (const std::exception& error) {
      warnings.emplace_back(error.what());
      continue;
    }
    if (first_name.empty()) {
      first = size;
      first_name = frame.file.string();
    } else if (size != first) {
      warnings.push_back(frame.file.string() + " has " + size_text(size.width, size.height) + " pixels, " + first_name +
                         " has " + size_text(first.width, first.height));
    }
  }
  return warnings;
}

void write_strip_index(const fs::path& index, const std::vector<StripFrame>& frames) {
  std::ofstream out(index);
  out << "# time_ns file [altitude_m]\n";
  for (const StripFrame& frame : frames) {
    const fs::path relative = fs::absolute(frame.file).lexically_relative(fs::absolute(index).parent_path());
    const bool beside = !relative.empty() && *relative.begin() != "..";
    const std::string file = beside ? relative.string() : fs::absolute(frame.file).string();
    if (file.find_first_of(" \t\r\n") != std::string::npos) {
      throw std::runtime_error("'" + file + "': blanks in the path of an image are not supported");
    }
    const std::string line =
        std::to_string(frame.time_ns) + " " + file + (frame.altitude.empty() ? "" : " " + frame.altitude);
    if (line.size() >= limits::max_path_bytes) throw std::runtime_error("'" + file + "': the path is too long");
    out << line << "\n";
  }
  if (!out.flush()) throw std::runtime_error(index.string() + " cannot be written: " + host::write_failure(errno));
}

}  // namespace ilp::host
