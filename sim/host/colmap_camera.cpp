#include "sim/host/colmap_camera.hpp"

#include <cmath>
#include <fstream>
#include <iomanip>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "fsw/vision/geometry/camera.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::host {
namespace {

constexpr double colmap_pixel_centre = 0.5;

CameraModel from_parameters(const std::string& model, const std::vector<double>& p) {
  CameraModel camera;
  const bool one_focal = model.rfind("SIMPLE_", 0) == 0 || model == "RADIAL";
  std::size_t i = 0;
  camera.fx = p[i++];
  camera.fy = one_focal ? camera.fx : p[i++];
  camera.cx = p[i++] - colmap_pixel_centre;
  camera.cy = p[i++] - colmap_pixel_centre;
  double* const distortion[] = {&camera.k1, &camera.k2, &camera.p1, &camera.p2};
  for (std::size_t d = 0; i < p.size(); ++i, ++d) *distortion[d] = p[i];
  return camera;
}

}  // namespace

CameraModel read_colmap_camera(const std::filesystem::path& path) {
  static const std::map<std::string, std::size_t> parameter_counts = {
      {"SIMPLE_PINHOLE", 3}, {"PINHOLE", 4}, {"SIMPLE_RADIAL", 4}, {"RADIAL", 5}, {"OPENCV", 8}};
  std::ifstream in(path);
  if (!in) throw std::runtime_error("camera file " + path.string() + " cannot be read");
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    const std::string place = "camera file " + path.string() + ", line " + std::to_string(number) + ": ";
    std::istringstream words(line);
    std::string id;
    if (!(words >> id) || id[0] == '#') continue;
    std::string model;
    long width = 0;
    long height = 0;
    if (!(words >> model >> width >> height)) {
      throw std::runtime_error(place + "expected CAMERA_ID MODEL WIDTH HEIGHT PARAMETERS...");
    }
    const auto known = parameter_counts.find(model);
    if (known == parameter_counts.end()) {
      throw std::runtime_error(place + "camera model " + model +
                               " is not supported; PINHOLE, OPENCV, RADIAL, SIMPLE_RADIAL, SIMPLE_PINHOLE are");
    }
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
    if (parameters.size() != known->second) {
      throw std::runtime_error(place + model + " has " + std::to_string(known->second) + " parameters, found " +
                               std::to_string(parameters.size()));
    }
    if (width <= 0 || height <= 0 || width > 1000000 || height > 1000000)
      throw std::runtime_error(place + "bad image size");
    CameraModel camera = from_parameters(model, parameters);
    camera.width = static_cast<std::int32_t>(width);
    camera.height = static_cast<std::int32_t>(height);
    const Status status = validate(camera);
    if (!status.ok()) {
      static const char* const reasons[] = {
          "",
          "image too small",
          ("absurd focal length: expected above 1 px, at most 1000 sides of the image, and "
           "fx and fy within a factor of 10"),
          "principal point far outside the image",
          "distortion is not invertible over the image",
          "a parameter is not finite"};
      const bool explained = status.is(StatusCode::invalid_argument) && status.a >= 1 && status.a <= 5;
      throw std::runtime_error(place + (explained ? reasons[status.a] : describe(status)));
    }
    return camera;
  }
  throw std::runtime_error("camera file " + path.string() +
                           " holds no camera: expected a line CAMERA_ID MODEL WIDTH HEIGHT PARAMETERS...");
}

void write_colmap_camera(const std::filesystem::path& path, const CameraModel& camera) {
  std::ofstream out(path);
  out << "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS (pixel centres at 0.5)\n"
      << std::setprecision(17) << "1 " << (camera.has_distortion() ? "OPENCV " : "PINHOLE ") << camera.width << " "
      << camera.height << " " << camera.fx << " " << camera.fy << " " << camera.cx + colmap_pixel_centre << " "
      << camera.cy + colmap_pixel_centre;
  if (camera.has_distortion()) out << " " << camera.k1 << " " << camera.k2 << " " << camera.p1 << " " << camera.p2;
  out << "\n";
  if (!out.flush()) throw std::runtime_error(path.string() + ": cannot be written");
}

}  // namespace ilp::host
