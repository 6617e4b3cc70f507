#include "sim/host/reference_cameras.hpp"

#include <charconv>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>
#include <stdexcept>

namespace ilp::host {
namespace {

constexpr std::size_t words_per_line = 19;
constexpr double largest_side_px = 1e6;

[[noreturn]] void fail(const std::string& place, const std::string& what) {
  throw std::runtime_error(place + what);
}

double number(const std::string& place, const std::string& word) {
  double value = 0;
  const char* const end = word.data() + word.size();
  const auto [rest, error] = std::from_chars(word.data(), end, value);
  if (error != std::errc() || rest != end || !std::isfinite(value))
    fail(place, "'" + word + "' is not a finite number");
  return value;
}

std::int32_t size_in_pixels(const std::string& place, const std::string& word) {
  const double value = number(place, word);
  if (!(value >= 1 && value <= largest_side_px) || value != std::floor(value)) {
    fail(place, "'" + word + "' is not an image size in pixels");
  }
  return static_cast<std::int32_t>(value);
}

// Published rotations carry as few as four digits.
bool is_rotation(const Mat3& r) {
  return (r * r.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff() < 1e-3 && r.determinant() > 0;
}

ReferenceCamera parse(const std::string& place, const std::vector<std::string>& words) {
  if (words.size() > 4 && (words[1].ends_with("PINHOLE") || words[1].ends_with("RADIAL") || words[1] == "OPENCV"))
    fail(place,
         "this is a camera file (--camera); reference poses are lines of name width height fx fy cx cy R(9) C(3)");
  if (words.size() != words_per_line) {
    fail(place, "expected 19 words (name width height fx fy cx cy R(9) C(3)), found " + std::to_string(words.size()));
  }
  ReferenceCamera result;
  result.name = words[0];
  result.camera.width = size_in_pixels(place, words[1]);
  result.camera.height = size_in_pixels(place, words[2]);
  double values[words_per_line] = {};
  for (std::size_t i = 3; i < words_per_line; ++i) values[i] = number(place, words[i]);
  result.camera.fx = values[3];
  result.camera.fy = values[4];
  result.camera.cx = values[5];
  result.camera.cy = values[6];
  if (!(result.camera.fx > 0 && result.camera.fy > 0)) fail(place, "the focal length is not positive");
  result.cam_from_world << values[7], values[8], values[9], values[10], values[11], values[12], values[13], values[14],
      values[15];
  if (!is_rotation(result.cam_from_world)) fail(place, "words 8 to 16 are not a rotation matrix");
  result.centre << values[16], values[17], values[18];
  return result;
}

// Shortest text that reads back to the same bits.
void put(std::ostream& out, double value) {
  char text[32];
  const auto [end, error] = std::to_chars(text, text + sizeof(text), value);
  if (error != std::errc()) throw std::logic_error("a double does not fit its text");
  out.put(' ').write(text, end - text);
}

}  // namespace

std::vector<ReferenceCamera> read_reference_cameras(const std::filesystem::path& path) {
  std::ifstream in(path);
  if (!in) throw std::runtime_error("reference poses " + path.string() + " cannot be read: check the path");
  std::vector<ReferenceCamera> cameras;
  std::set<std::string> names;
  std::string line;
  for (int line_number = 1; std::getline(in, line); ++line_number) {
    std::istringstream text(line);
    std::vector<std::string> words;
    for (std::string word; text >> word;) words.push_back(word);
    if (words.empty() || words[0][0] == '#') continue;
    const std::string place = "reference poses " + path.string() + ", line " + std::to_string(line_number) + ": ";
    cameras.push_back(parse(place, words));
    if (!names.insert(words[0]).second) fail(place, "a second pose for '" + words[0] + "'");
  }
  if (cameras.empty()) throw std::runtime_error("reference poses " + path.string() + ": the file holds no pose");
  return cameras;
}

void write_reference_cameras(const std::filesystem::path& path, const std::string& title,
                             const std::vector<ReferenceCamera>& cameras) {
  std::ofstream out(path, std::ios::binary);
  out << "# " << title << "\n# name width height fx fy cx cy r11 r12 r13 r21 r22 r23 r31 r32 r33 Cx Cy Cz\n";
  for (const ReferenceCamera& c : cameras) {
    if (c.name.empty() || c.name[0] == '#' || c.name.find_first_of(" \t\r\n") != std::string::npos) {
      throw std::runtime_error(path.string() + ": '" + c.name +
                               "' is no valid image name: it must not be empty, begin with # or contain blanks");
    }
    out << c.name << ' ' << c.camera.width << ' ' << c.camera.height;
    for (const double value : {c.camera.fx, c.camera.fy, c.camera.cx, c.camera.cy}) put(out, value);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) put(out, c.cam_from_world(row, column));
    }
    for (int i = 0; i < 3; ++i) put(out, c.centre[i]);
    out << '\n';
  }
  if (!out.flush()) throw std::runtime_error(path.string() + " cannot be written");
}

}  // namespace ilp::host
