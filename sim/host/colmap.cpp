#include "sim/host/colmap.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "fsw/vision/geometry/camera.hpp"
#include "sim/host/files.hpp"
#include "sim/host/image_io.hpp"
#include "sim/host/status_error.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::host {
namespace {

constexpr double colmap_pixel_centre = 0.5;

constexpr const char* example = "1 PINHOLE 640 480 550 550 320 240";
/// name width height fx fy cx cy R C
constexpr std::ptrdiff_t words_of_reference_pose = 19;

std::ptrdiff_t word_count(const std::string& line) {
  std::istringstream words(line);
  return std::distance(std::istream_iterator<std::string>(words), std::istream_iterator<std::string>());
}

struct Model {
  const char* name;
  std::size_t count;
};
constexpr Model models[] = {{"PINHOLE", 4},        {"OPENCV", 8},         {"FULL_OPENCV", 12},
                            {"OPENCV_FISHEYE", 8}, {"RADIAL", 5},         {"SIMPLE_RADIAL", 4},
                            {"SIMPLE_PINHOLE", 3}, {"RADIAL_FISHEYE", 5}, {"SIMPLE_RADIAL_FISHEYE", 4}};

std::string model_names() {
  std::string names;
  for (const Model& model : models) names += (names.empty() ? "" : ", ") + std::string(model.name);
  return names;
}

CameraModel from_parameters(const std::string& model, const std::vector<double>& p) {
  CameraModel camera;
  const bool one_focal = model.starts_with("SIMPLE_") || model.starts_with("RADIAL");
  std::size_t i = 0;
  camera.fx = p[i++];
  camera.fy = one_focal ? camera.fx : p[i++];
  camera.cx = p[i++] - colmap_pixel_centre;
  camera.cy = p[i++] - colmap_pixel_centre;
  double* const brown[] = {&camera.k1, &camera.k2, &camera.p1, &camera.p2,
                           &camera.k3, &camera.k4, &camera.k5, &camera.k6};
  double* const fisheye[] = {&camera.k1, &camera.k2, &camera.k3, &camera.k4};
  if (model.ends_with("_FISHEYE")) camera.lens = Lens::fisheye;
  double* const* coefficients = camera.lens == Lens::fisheye ? fisheye : brown;
  for (std::size_t d = 0; i < p.size(); ++i, ++d) *coefficients[d] = p[i];
  return camera;
}

std::string text_of(double value, const char* format = " %.17g") {
  std::array<char, 40> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, value);
  return buffer.data();
}

std::string images_text(const ColmapText& model) {
  std::string text =
      "# Image list with two lines of data per image:\n"
      "#   IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n#   POINTS2D[] as (X, Y, POINT3D_ID)\n";
  for (const ColmapView& view : model.views) {
    text += std::to_string(view.id);
    for (const double q : view.q_cam_from_world) text += text_of(q);
    for (int i = 0; i < 3; ++i) text += text_of(view.translation[i]);
    text += " 1 " + view.name + "\n";
    const char* first = "%.9g";
    for (const ColmapObservation& o : view.seen) {
      text += text_of(o.x + 0.5, first) + text_of(o.y + 0.5, " %.9g") + " " + std::to_string(o.point + 1);
      first = " %.9g";
    }
    text += "\n";
  }
  return text;
}

std::string points_text(const ColmapText& model) {
  std::string text =
      "# 3D point list with one line of data per point:\n"
      "#   POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n";
  for (std::size_t i = 0; i < model.points.size(); ++i) {
    const ColmapPoint& point = model.points[i];
    text += std::to_string(i + 1);
    for (int axis = 0; axis < 3; ++axis) text += text_of(point.position[axis]);
    const std::string grey = " " + std::to_string(point.grey);
    text += grey + grey + grey + text_of(point.error_px, " %.6g");
    for (const auto& [view, index] : point.track) text += " " + std::to_string(view) + " " + std::to_string(index);
    text += "\n";
  }
  return text;
}

CameraModel camera_of_line(const std::string& line, const std::string& place) {
  std::istringstream words(line);
  std::string id, model;
  long width = 0;
  long height = 0;
  if (!(words >> id >> model >> width >> height)) {
    throw std::runtime_error(place + "expected CAMERA_ID MODEL WIDTH HEIGHT PARAMETERS..., for example " + example);
  }
  if (word_count(line) == words_of_reference_pose)
    throw std::runtime_error(place + "this is a line of reference poses (--reference); a camera is written " + example);
  const auto* known = std::ranges::find_if(models, [&](const Model& m) { return model == m.name; });
  if (known == std::end(models))
    throw std::runtime_error(place + "camera model " + model + " is not supported; " + model_names() + " are");
  std::vector<double> parameters;
  for (std::string word; words >> word;) {
    std::size_t used = 0;
    double value = std::nan("");
    try {
      value = std::stod(word, &used);
    } catch (const std::exception&) {
      used = 0;
    }
    if (used != word.size() || !std::isfinite(value))
      throw std::runtime_error(place + "'" + word + "' is not a finite number");
    parameters.push_back(value);
  }
  if (parameters.size() != known->count) {
    throw std::runtime_error(place + model + " has " + std::to_string(known->count) + " parameters, found " +
                             std::to_string(parameters.size()));
  }
  if (width <= 0 || height <= 0 || width > largest_image_side || height > largest_image_side)
    throw std::runtime_error(place + "image size " + size_text(width, height) + ": expected from 1 to " +
                             std::to_string(largest_image_side) + " pixels on a side");
  CameraModel camera = from_parameters(model, parameters);
  camera.width = static_cast<std::int32_t>(width);
  camera.height = static_cast<std::int32_t>(height);
  const Status status = validate_of_any_size(camera);
  if (!status.ok()) throw std::runtime_error(place + status_sentence(status));
  return camera;
}

/// A comment "readout_s 0.03", for which COLMAP's format has no place; any other one says nothing.
void read_readout(const std::string& comment, const std::string& place, double& readout_s) {
  std::istringstream words(comment);
  std::string name, value, more;
  if (!(words >> name) || name != "readout_s") return;
  words >> value;
  std::size_t used = 0;
  try {
    readout_s = std::stod(value, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (value.empty() || used != value.size() || !std::isfinite(readout_s) || words >> more)
    throw std::runtime_error(place + "readout_s takes one finite number, the seconds from the first row to the last");
}

}  // namespace

CameraModel read_colmap_camera(const std::filesystem::path& path) {
  std::ifstream in(path);
  const std::string file = "camera file " + path.string();
  if (!in) throw std::runtime_error(file + " cannot be read: check the path");
  std::optional<CameraModel> camera;
  std::string line, first_id;
  double readout_s = 0;
  for (int number = 1; std::getline(in, line); ++number) {
    if (number == 1 && line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);  // a byte-order mark
    std::istringstream words(line);
    std::string id;
    const std::string place = file + ", line " + std::to_string(number) + ": ";
    if (!(words >> id)) continue;
    if (id[0] == '#') {
      read_readout(line.substr(line.find('#') + 1), place, readout_s);
      continue;
    }
    if (camera) {
      throw std::runtime_error(file + " has several cameras (" + first_id + ", " + id +
                               ", ...): a flight has one; keep the line of its camera, and only that one's images");
    }
    first_id = id;
    camera = camera_of_line(line, place);
  }
  if (!camera)
    throw std::runtime_error(file + " holds no camera: expected a line CAMERA_ID MODEL WIDTH HEIGHT PARAMETERS...");
  camera->readout_s = readout_s;
  const Status status = validate_of_any_size(*camera);
  if (!status.ok()) throw std::runtime_error(file + ": " + status_sentence(status));
  return *camera;
}

std::string colmap_camera_line(const CameraModel& c) {
  std::vector<double> p = {c.fx, c.fy, c.cx + colmap_pixel_centre, c.cy + colmap_pixel_centre};
  std::string line = "1 PINHOLE ";
  if (c.lens == Lens::fisheye) {
    line = "1 OPENCV_FISHEYE ";
    p.insert(p.end(), {c.k1, c.k2, c.k3, c.k4});
  } else if (!c.is_plain()) {
    line = "1 FULL_OPENCV ";
    p.insert(p.end(), {c.k1, c.k2, c.p1, c.p2, c.k3, c.k4, c.k5, c.k6});
  } else if (c.has_distortion()) {
    line = "1 OPENCV ";
    p.insert(p.end(), {c.k1, c.k2, c.p1, c.p2});
  }
  line += std::to_string(c.width) + " " + std::to_string(c.height);
  for (const double value : p) line += text_of(value);
  return line + "\n";
}

void write_colmap_camera(const std::filesystem::path& path, const CameraModel& camera) {
  std::ofstream out(path);
  out << "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS (pixel centres at 0.5)\n";
  if (camera.readout_s != 0) out << "# readout_s" << text_of(camera.readout_s) << "\n";
  out << colmap_camera_line(camera);
  if (!out.flush()) throw std::runtime_error(path.string() + ": cannot be written: " + host::write_failure(errno));
}

void write_colmap_text(const ColmapText& model, const std::filesystem::path& folder) {
  update_file(folder / "images.txt", images_text(model));
  update_file(folder / "points3D.txt", points_text(model));
}

}  // namespace ilp::host
