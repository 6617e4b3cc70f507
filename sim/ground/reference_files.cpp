#include "sim/ground/reference_files.hpp"

#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <system_error>

#include "sim/ground/safe_name.hpp"
#include "sim/io/image_io.hpp"

namespace ilp::ground {
namespace {

bool parse_line(const std::string& line, std::string& name, ReferencePose& pose) {
  std::istringstream in(line);
  in.imbue(std::locale::classic());
  double ignored = 0;
  in >> name;
  for (int i = 0; i < 6; ++i) in >> ignored;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) in >> pose.cam_from_world(row, column);
  }
  for (int i = 0; i < 3; ++i) in >> pose.centre[i];
  if (!in || !pose.centre.allFinite()) return false;
  const Mat3 gram = pose.cam_from_world * pose.cam_from_world.transpose();
  return (gram - Mat3::Identity()).cwiseAbs().maxCoeff() < 1e-3 && pose.cam_from_world.determinant() > 0;
}

}  // namespace

ReferenceFiles::ReferenceFiles(const std::filesystem::path& poses, std::filesystem::path depth_folder)
    : depth_folder_(std::move(depth_folder)) {
  std::ifstream file(poses);
  if (!file) throw std::runtime_error("cannot read the reference poses " + poses.string());
  std::size_t number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#') continue;
    std::string name;
    ReferencePose pose;
    if (!parse_line(line, name, pose)) {
      throw std::runtime_error(poses.string() + ", line " + std::to_string(number) +
                               ": expected name width height fx fy cx cy R(9, a rotation) C(3)");
    }
    poses_[stem(safe_name(name))] = pose;
  }
  if (poses_.empty()) throw std::runtime_error(poses.string() + " holds no poses");
}

const ReferencePose* ReferenceFiles::pose(const std::string& name) const {
  const auto found = poses_.find(stem(name));
  return found == poses_.end() ? nullptr : &found->second;
}

Raster<float> ReferenceFiles::depth(const std::string& name) const {
  if (depth_folder_.empty()) return {};
  for (const std::string& base : {stem(name), name}) {
    const std::filesystem::path path = depth_folder_ / (base + ".pfm");
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) continue;
    sim::Image<float> image = sim::read_pfm(path);
    Raster<float> depth;
    depth.width = image.width;
    depth.height = image.height;
    depth.samples = std::move(image.pixels);
    return depth;
  }
  return {};
}

}  // namespace ilp::ground
