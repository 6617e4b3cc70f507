// model-error: how far the cameras of a COLMAP text model lie from reference cameras, for models of any program.

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/host/alignment.hpp"
#include "sim/host/reference_cameras.hpp"
#include "sim/tools/lab/colmap_reader.hpp"

namespace ilp {
namespace {

constexpr const char* usage =
    "usage: model-error REFERENCE NAMES MODEL\n"
    "  REFERENCE  poses, a line per image: name width height fx fy cx cy R(3x3) C(3)\n"
    "  NAMES      names of the images that were to be posed, one a line, in the order of the flight\n"
    "  MODEL      folder with cameras.txt, images.txt, points3D.txt\n"
    "prints: images posed, images to pose, position error after the best similarity transform, mean and largest,\n"
    "in % of the distance flown through all images to pose";

std::vector<std::string> read_names(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw std::runtime_error("cannot read " + path);
  std::vector<std::string> names;
  for (std::string name; in >> name;) names.push_back(name);
  if (names.size() < 3) throw std::runtime_error(path + " has fewer than three names: any two positions fit");
  return names;
}

std::map<std::string, Vec3> read_centres(const std::string& path) {
  std::map<std::string, Vec3> centres;
  for (const host::ReferenceCamera& camera : host::read_reference_cameras(path)) centres[camera.name] = camera.centre;
  return centres;
}

double distance_flown(const std::vector<std::string>& names, const std::map<std::string, Vec3>& centres) {
  double length = 0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (centres.count(names[i]) == 0) throw std::runtime_error("the reference has no image " + names[i]);
    if (i > 0) length += (centres.at(names[i]) - centres.at(names[i - 1])).norm();
  }
  return length;
}

int run(const std::string& reference_file, const std::string& name_file, const std::string& folder) {
  const std::vector<std::string> names = read_names(name_file);
  const std::map<std::string, Vec3> centres = read_centres(reference_file);
  const double length = distance_flown(names, centres);
  const std::set<std::string> wanted(names.begin(), names.end());
  std::vector<Vec3> found, truth;
  for (const lab::ColmapImage& image : lab::read_colmap_model(folder).images) {
    if (wanted.count(image.name) == 0) throw std::runtime_error(folder + " has another image, " + image.name);
    found.push_back(inverse(image.cam_from_world).translation);
    truth.push_back(centres.at(image.name));
  }
  const std::optional<host::Similarity3> aligned = host::align_positions(found, truth);
  if (found.size() < 3 || !aligned) throw std::runtime_error(folder + " has too few posed images to align");
  double sum = 0, largest = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double error = (*aligned * found[i] - truth[i]).norm();
    sum += error;
    largest = std::max(largest, error);
  }
  const double percent = 100 / length;
  std::printf("%zu %zu %.4f %.4f\n", found.size(), names.size(), percent * sum / static_cast<double>(found.size()),
              percent * largest);
  return 0;
}

}  // namespace
}  // namespace ilp

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << ilp::usage << "\n";
    return 2;
  }
  try {
    return ilp::run(argv[1], argv[2], argv[3]);
  } catch (const std::exception& error) {
    std::cerr << "model-error: " << error.what() << "\n";
    return 1;
  }
}
