#include "sim/host/camera_file.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <ostream>
#include <sstream>
#include <stdexcept>

#include "fsw/vision/geometry/camera.hpp"
#include "sim/host/colmap.hpp"
#include "sim/host/image_io.hpp"
#include "sim/host/status_error.hpp"
#include "sim/host/text_format.hpp"
#include "sim/host/yaml_file.hpp"

namespace ilp::host {
namespace {

/// COLMAP's lines have no colon, and YAML's keys do.
bool is_yaml(const std::string& text) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#') continue;
    return line[first] == '{' || line.starts_with("---") || line.find(':') != std::string::npos;
  }
  return false;
}

/// Coefficients in OpenCV's order: k1 k2 p1 p2, k3, k4 k5 k6, and four of a thin prism and two of a tilted sensor.
void set_coefficients(const std::vector<double>& d, Lens lens, const std::string& key, CameraModel& camera) {
  camera.lens = lens;
  if (lens == Lens::fisheye) {
    if (d.size() != 4)
      throw std::runtime_error(key + " has " + counted(d.size(), "number") + ": a fisheye has four, k1 to k4");
    camera.k1 = d[0];
    camera.k2 = d[1];
    camera.k3 = d[2];
    camera.k4 = d[3];
    return;
  }
  const std::size_t counts[] = {0, 4, 5, 8, 12, 14};
  if (std::ranges::find(counts, d.size()) == std::end(counts)) {
    throw std::runtime_error(key + " has " + counted(d.size(), "number") +
                             ": OpenCV's lens has 0, 4 (k1 k2 p1 p2), 5 (and k3), 8 (and k4 k5 k6), 12 or 14");
  }
  double* const members[] = {&camera.k1, &camera.k2, &camera.p1, &camera.p2,
                             &camera.k3, &camera.k4, &camera.k5, &camera.k6};
  for (std::size_t i = 0; i < d.size(); ++i) {
    if (i < std::size(members)) {
      *members[i] = d[i];
    } else if (d[i] != 0) {
      throw std::runtime_error(key +
                               " has a thin prism or a tilted sensor, which is not supported: calibrate again "
                               "with eight coefficients");
    }
  }
}

void set_size(double width, double height, CameraModel& camera) {
  const auto is_side = [](double side) { return side >= 1 && side <= largest_image_side && side == std::floor(side); };
  if (!is_side(width) || !is_side(height)) {
    throw std::runtime_error("the image size is no two whole numbers from 1 to " + std::to_string(largest_image_side));
  }
  camera.width = static_cast<std::int32_t>(width);
  camera.height = static_cast<std::int32_t>(height);
}

CameraModel opencv_camera(const YamlNode& file) {
  CameraModel camera;
  const std::vector<double> k = file.at("camera_matrix").matrix();
  if (k.size() != 9) throw std::runtime_error("camera_matrix is not 3 x 3");
  if (k[1] != 0 || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1)
    throw std::runtime_error("camera_matrix is not [fx 0 cx; 0 fy cy; 0 0 1]");
  camera.fx = k[0];
  camera.cx = k[2];
  camera.fy = k[4];
  camera.cy = k[5];
  set_size(file.at("image_width").number(), file.at("image_height").number(), camera);
  Lens lens = Lens::brown;
  if (const auto flag = file.find("fisheye_model"); flag && flag->text() != "0" && flag->text() != "false")
    lens = Lens::fisheye;
  for (const char* key : {"distortion_model", "camera_model"}) {
    const auto model = file.find(key);
    if (!model) continue;
    const std::string word = lower_case(model->text());
    const char* const browns[] = {"plumb_bob", "rational_polynomial", "radtan", "brown", "pinhole", "opencv"};
    if (word == "fisheye" || word == "equidistant") {
      lens = Lens::fisheye;
    } else if (std::ranges::find(browns, word) == std::end(browns)) {
      throw std::runtime_error(std::string(key) + " " + model->text() +
                               " is not supported; plumb_bob, rational_polynomial, equidistant and fisheye are");
    }
  }
  if (const auto coefficients = file.find("distortion_coefficients"))
    set_coefficients(coefficients->matrix(), lens, "distortion_coefficients", camera);
  camera.lens = lens;
  return camera;
}

CameraModel kalibr_camera(const YamlNode& file) {
  const YamlNode node = file.at("cam0");
  if (file.find("cam1")) {
    throw std::runtime_error(
        "it has several cameras (cam0, cam1, ...): a flight has one; keep the part of its camera, "
        "named cam0");
  }
  const std::string model = node.at("camera_model").text();
  if (model != "pinhole")
    throw std::runtime_error("camera_model " + model + " is not supported; pinhole is (with radtan or equidistant)");
  const std::vector<double> k = node.at("intrinsics").numbers();
  if (k.size() != 4) throw std::runtime_error("intrinsics are not fx fy cx cy");
  const std::vector<double> size = node.at("resolution").numbers();
  if (size.size() != 2) throw std::runtime_error("resolution is not width and height");
  CameraModel camera;
  camera.fx = k[0];
  camera.fy = k[1];
  camera.cx = k[2];
  camera.cy = k[3];
  set_size(size[0], size[1], camera);
  const auto word = node.find("distortion_model");
  const std::string distortion = word ? word->text() : "none";
  if (distortion == "none") return camera;
  if (distortion != "radtan" && distortion != "equidistant")
    throw std::runtime_error("distortion_model " + distortion + " is not supported; none, radtan and equidistant are");
  set_coefficients(node.at("distortion_coeffs").numbers(), distortion == "radtan" ? Lens::brown : Lens::fisheye,
                   "distortion_coeffs", camera);
  return camera;
}

}  // namespace

CameraModel read_camera_file(const std::filesystem::path& path) {
  std::ifstream in(path);
  const std::string place = "camera file " + path.string() + ": ";
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  if (!in.is_open() || in.bad())
    throw std::runtime_error("camera file " + path.string() + " cannot be read: check the path");
  if (text.starts_with("<?xml")) throw std::runtime_error(place + "it is XML: write it as YAML (FileStorage, .yml)");
  if (!is_yaml(text)) return read_colmap_camera(path);
  try {
    const YamlFile file(text);
    if (!file.root().find("cam0") && !file.root().find("camera_matrix"))
      throw std::runtime_error("it has neither camera_matrix (OpenCV, ROS) nor cam0 (Kalibr)");
    const CameraModel camera = file.root().find("cam0") ? kalibr_camera(file.root()) : opencv_camera(file.root());
    const Status status = validate_of_any_size(camera);
    if (!status.ok()) throw std::runtime_error(status_sentence(status));
    return camera;
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(place + error.what());
  }
}

CameraModel camera_for_size(const CameraModel& camera, std::int32_t width, std::int32_t height,
                            const std::string& images, std::ostream& messages) {
  if (width == camera.width && height == camera.height) return camera;
  const double x = static_cast<double>(width) / camera.width, y = static_cast<double>(height) / camera.height;
  const std::string sizes = images + " " + size_text(width, height) + " pixels, the camera file says " +
                            size_text(camera.width, camera.height);
  // Sides are rounded to whole pixels of the smaller image.
  if (std::fabs(x - y) * std::max(camera.width, camera.height) > std::max(1.0, std::max(x, y))) {
    const bool turned = width < height && camera.width > camera.height;
    throw std::runtime_error(sizes + (turned ? ": they are turned upright" : ": of another shape, they are cut") +
                             "; use the camera file of these images");
  }
  CameraModel out = camera;
  out.width = width;
  out.height = height;
  out.fx *= x;
  out.fy *= y;
  out.cx = (camera.cx + 0.5) * x - 0.5;
  out.cy = (camera.cy + 0.5) * y - 0.5;
  messages << sizes << ": scaled, the focal length is " << brief(out.fx) << " px\n";
  return out;
}

CameraModel read_global_shutter_camera(const std::filesystem::path& path) {
  const CameraModel camera = read_camera_file(path);
  if (camera.readout_s != 0)
    throw std::runtime_error("camera file " + path.string() +
                             " has a rolling shutter, which only a flight corrects: take readout_s away to use the "
                             "images as they were read");
  const Status status = validate(camera);
  if (!status.ok()) throw std::runtime_error("camera file " + path.string() + ": " + status_sentence(status));
  return camera;
}

}  // namespace ilp::host
