#include "sim/tools/lab/colmap_reader.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "sim/host/colmap.hpp"

namespace ilp::lab {
namespace fs = std::filesystem;
namespace {

constexpr double colmap_pixel_centre = 0.5;

/// Lines of one file of the model, with words that are checked as they are taken.
class ModelFile {
 public:
  explicit ModelFile(const fs::path& path) : path_(path), in_(path) {
    if (!in_) throw std::runtime_error(path.string() + " cannot be read: check the path");
  }
  /// Skips comments and, if asked to, empty lines.
  bool next_line(bool skip_empty) {
    std::string line;
    while (std::getline(in_, line)) {
      ++number_;
      if (!line.empty() && line.back() == '\r') line.pop_back();
      const bool empty = line.find_first_not_of(" \t") == std::string::npos;
      if ((skip_empty && empty) || (!line.empty() && line[0] == '#')) continue;
      words_ = std::istringstream(line);
      return true;
    }
    words_ = std::istringstream();
    return false;
  }
  bool more() { return !(words_ >> std::ws).eof(); }
  double number(const char* name) {
    const std::string word = take(name);
    double value = 0;
    const auto [rest, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || rest != word.data() + word.size() || !std::isfinite(value)) {
      fail("'" + word.substr(0, 40) + "' is not a finite number (" + name + ")");
    }
    return value;
  }
  std::int64_t id(const char* name) {
    const std::string word = take(name);
    std::int64_t value = 0;
    const auto [rest, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || rest != word.data() + word.size()) {
      fail("'" + word.substr(0, 40) + "' is not a whole number (" + name + ")");
    }
    return value;
  }
  /// All that is left of the line.
  std::string rest(const char* name) {
    std::string text;
    std::getline(words_ >> std::ws, text);
    if (text.empty()) fail(std::string("expected ") + name);
    return text;
  }
  [[noreturn]] void fail(const std::string& message) const {
    throw std::runtime_error(path_.string() + ", line " + std::to_string(number_) + ": " + message);
  }

 private:
  std::string take(const char* name) {
    std::string word;
    if (!(words_ >> word)) fail(std::string("expected ") + name);
    return word;
  }
  fs::path path_;
  std::ifstream in_;
  std::istringstream words_;
  int number_ = 0;
};

std::int64_t first_camera_id(const fs::path& cameras) {
  ModelFile file(cameras);
  if (!file.next_line(true)) throw std::runtime_error(cameras.string() + " holds no camera");
  return file.id("CAMERA_ID");
}

RigidTransform read_pose(ModelFile& file) {
  double q[4];
  static const char* const q_names[] = {"QW", "QX", "QY", "QZ"};
  for (int i = 0; i < 4; ++i) q[i] = file.number(q_names[i]);
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  constexpr double tolerance = 1e-3;
  if (!(std::fabs(length - 1) < tolerance)) file.fail("the quaternion does not have unit length");
  for (double& component : q) component /= length;
  const double x = file.number("TX"), y = file.number("TY"), z = file.number("TZ");
  return {rotation_from_quaternion(q), Vec3(x, y, z)};
}

void read_images(const fs::path& path, std::int64_t camera_id, ColmapModel& model) {
  ModelFile file(path);
  while (file.next_line(true)) {
    ColmapImage image;
    file.id("IMAGE_ID");
    image.cam_from_world = read_pose(file);
    if (file.id("CAMERA_ID") != camera_id)
      file.fail("all images must have the first camera of cameras.txt (colmap --ImageReader.single_camera 1)");
    image.name = file.rest("NAME");
    // The second line of an image, empty when it sees no point.
    if (file.next_line(false)) {
      while (file.more()) {
        const double x = file.number("X") - colmap_pixel_centre, y = file.number("Y") - colmap_pixel_centre;
        const std::int64_t point = file.id("POINT3D_ID");
        if (point >= 0) image.seen[point] = Vec2(x, y);
      }
    }
    model.images.push_back(std::move(image));
  }
}

void read_points(const fs::path& path, ColmapModel& model) {
  ModelFile file(path);
  while (file.next_line(true)) {
    const std::int64_t id = file.id("POINT3D_ID");
    const double x = file.number("X"), y = file.number("Y"), z = file.number("Z");
    model.points[id] = Vec3(x, y, z);
  }
}

}  // namespace

ColmapModel read_colmap_model(const fs::path& folder) {
  ColmapModel model;
  model.camera = host::read_colmap_camera(folder / "cameras.txt");
  read_images(folder / "images.txt", first_camera_id(folder / "cameras.txt"), model);
  read_points(folder / "points3D.txt", model);
  return model;
}

const ColmapImage& find_image(const ColmapModel& model, const std::string& file) {
  const fs::path path(file);
  for (const ColmapImage& image : model.images) {
    if (fs::path(image.name) == path) return image;
  }
  for (const ColmapImage& image : model.images) {
    if (fs::path(image.name).filename() == path.filename()) return image;
  }
  constexpr std::size_t most_named = 5;
  std::string names;
  for (std::size_t i = 0; i < std::min(model.images.size(), most_named); ++i)
    names += (i > 0 ? ", " : "") + model.images[i].name;
  throw std::runtime_error("the model has no image " + path.filename().string() + ": it has " +
                           std::to_string(model.images.size()) + ", among them " + names);
}

}  // namespace ilp::lab
