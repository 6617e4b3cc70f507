#include "sim/ground/control/control_file.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>

#include "sim/host/cell_file.hpp"

namespace ilp::control {
namespace {

constexpr std::size_t fixed_words = 6, words_of_mark = 3;

[[noreturn]] void refuse(const std::string& what) {
  throw std::runtime_error(what);
}

double number(const std::string& word, const std::string& what) {
  char* end = nullptr;
  const double value = std::strtod(word.c_str(), &end);
  if (word.empty() || *end != '\0' || !std::isfinite(value)) refuse(what + " is \"" + word + "\", a number expected");
  return value;
}

ControlPoint point_of(std::vector<std::string> words, bool geographic) {
  // Spreadsheets fill all rows up to the longest one.
  while (words.size() > fixed_words && words.back().empty()) words.pop_back();
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

std::string in_small_letters(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

bool geographic_of(std::vector<std::string> words) {
  while (!words.empty() && words.back().empty()) words.pop_back();
  std::string line;
  for (const std::string& word : words) line += (line.empty() ? "" : ",") + in_small_letters(word);
  if (line == "name,x,y,height,sigma,role") return false;
  if (line == "name,longitude,latitude,height,sigma,role") return true;
  refuse(
      "the first line must be name,x,y,height,sigma,role or name,longitude,latitude,height,sigma,role, or the "
      "coordinate system of a gcp_list.txt, such as EPSG:32633");
}

ControlFile read_table(const host::TextLines& text, int& line) {
  ControlFile file;
  std::set<std::string> names;
  bool begun = false;
  for (const host::CellLine& row : host::cells_of(text).lines) {
    line = row.number;
    if (!begun) {
      file.geographic = geographic_of(row.cells);
      begun = true;
      continue;
    }
    file.points.push_back(point_of(row.cells, file.geographic));
    if (!names.insert(file.points.back().name).second) refuse("the name " + file.points.back().name + " stands twice");
  }
  return file;
}

/// As GDAL knows it; empty for a line that is no coordinate system.
std::string system_of(std::string line) {
  line.erase(line.find_last_not_of(" \t\r") + 1);
  if (in_small_letters(line.substr(0, 5)) == "epsg:" || line.starts_with("+proj") || line.starts_with("PROJCS") ||
      line.starts_with("PROJCRS"))
    return line;
  int zone = 0;
  char side = 0;
  if (std::sscanf(line.c_str(), "WGS84 UTM %2d%c", &zone, &side) != 2 || zone < 1 || zone > 60 ||
      (side != 'N' && side != 'S'))
    return {};
  return "EPSG:" + std::to_string((side == 'N' ? 32600 : 32700) + zone);
}

ControlFile read_gcp_list(const std::vector<host::TextLine>& lines, int& line) {
  ControlFile file;
  file.system = system_of(lines.front().text);
  file.original_pixels = true;
  std::map<std::string, std::size_t> known;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    line = lines[i].number;
    std::istringstream in(lines[i].text);
    std::vector<std::string> words;
    for (std::string word; in >> word;) words.push_back(word);
    if (words.size() < 6)
      refuse(std::to_string(words.size()) + " values; x, y, height, column, row and image expected, then a name");
    const Vec3 place(number(words[0], "x"), number(words[1], "y"), number(words[2], "height"));
    const std::string key = words.size() > 6 ? words[6] : words[0] + " " + words[1] + " " + words[2];
    const auto [found, is_new] = known.emplace(key, file.points.size());
    if (is_new) {
      ControlPoint& point = file.points.emplace_back();
      point.name = words.size() > 6 ? words[6] : "point " + std::to_string(file.points.size());
      point.place = place;
      point.sigma_m = assumed_sigma_m;
    }
    ControlPoint& point = file.points[found->second];
    if ((point.place - place).norm() > 0) refuse("the point " + point.name + " has two places");
    point.marks.push_back({words[5], {number(words[3], "column"), number(words[4], "row")}});
  }
  return file;
}

}  // namespace

ControlFile read_control_file(const std::filesystem::path& path) {
  const host::TextLines text = host::read_text_lines(path);
  int line = 1;
  ControlFile file;
  try {
    const bool list = !text.lines.empty() && !system_of(text.lines.front().text).empty();
    file = list ? read_gcp_list(text.lines, line) : read_table(text, line);
  } catch (const std::runtime_error& error) {
    refuse("control points " + path.string() + ", line " + std::to_string(line) + ": " + error.what());
  }
  if (file.points.empty()) refuse("control points " + path.string() + ": no point in the file");
  return file;
}

}  // namespace ilp::control
