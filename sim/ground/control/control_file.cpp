#include "sim/ground/control/control_file.hpp"

#include <cmath>
#include <cstdlib>
#include <set>
#include <sstream>
#include <stdexcept>

#include "sim/host/files.hpp"

namespace ilp::control {
namespace {

constexpr std::size_t fixed_words = 6, words_of_mark = 3;

[[noreturn]] void refuse(const std::string& what) {
  throw std::runtime_error(what);
}

std::string trimmed(const std::string& text) {
  const char* const blanks = " \t\r";
  const std::size_t first = text.find_first_not_of(blanks);
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::vector<std::string> words_of(const std::string& line) {
  std::vector<std::string> words;
  std::istringstream in(line);
  for (std::string word; std::getline(in, word, ',');) words.push_back(trimmed(word));
  return words;
}

double number(const std::string& word, const std::string& what) {
  char* end = nullptr;
  const double value = std::strtod(word.c_str(), &end);
  if (word.empty() || *end != '\0' || !std::isfinite(value)) refuse(what + " is \"" + word + "\", a number expected");
  return value;
}

ControlPoint point_of(const std::vector<std::string>& words, bool geographic) {
  if (words.size() < fixed_words || (words.size() - fixed_words) % words_of_mark != 0) {
    refuse(std::to_string(words.size()) +
           " values; name, two coordinates, height, sigma, role, and image, column, row for each image expected");
  }
  ControlPoint point;
  point.name = words[0];
  if (point.name.empty()) refuse("a point without a name");
  point.place = {number(words[1], geographic ? "longitude" : "x"), number(words[2], geographic ? "latitude" : "y"),
                 number(words[3], "height")};
  if (geographic && !(std::fabs(point.place.x()) <= 360 && std::fabs(point.place.y()) <= 90)) {
    refuse("longitudes are from -180 to 360 and latitudes from -90 to 90 degrees");
  }
  point.sigma_m = number(words[4], "sigma");
  if (!(point.sigma_m > 0)) refuse("sigma must be positive, in metres");
  if (words[5] != "control" && words[5] != "check")
    refuse("the role is \"" + words[5] + "\", control or check expected");
  point.check = words[5] == "check";
  for (std::size_t at = fixed_words; at < words.size(); at += words_of_mark) {
    point.marks.push_back({words[at], {number(words[at + 1], "column"), number(words[at + 2], "row")}});
  }
  return point;
}

bool geographic_of(const std::string& line) {
  if (line == "name,x,y,height,sigma,role") return false;
  if (line == "name,longitude,latitude,height,sigma,role") return true;
  refuse("the first line must be name,x,y,height,sigma,role or name,longitude,latitude,height,sigma,role");
}

}  // namespace

ControlFile read_control_file(const std::filesystem::path& path) {
  const std::vector<std::uint8_t> bytes = host::read_file(path);
  std::istringstream in(std::string(bytes.begin(), bytes.end()));
  ControlFile file;
  std::set<std::string> names;
  bool begun = false;
  int number_of_line = 0;
  for (std::string line; std::getline(in, line);) {
    ++number_of_line;
    line = trimmed(line);
    if (line.empty() || line[0] == '#') continue;
    try {
      if (!begun) {
        file.geographic = geographic_of(line);
        begun = true;
        continue;
      }
      file.points.push_back(point_of(words_of(line), file.geographic));
      if (!names.insert(file.points.back().name).second)
        refuse("the name " + file.points.back().name + " stands twice");
    } catch (const std::runtime_error& error) {
      refuse("control points " + path.string() + ", line " + std::to_string(number_of_line) + ": " + error.what());
    }
  }
  if (file.points.empty()) refuse("control points " + path.string() + ": no point in the file");
  return file;
}

}  // namespace ilp::control
