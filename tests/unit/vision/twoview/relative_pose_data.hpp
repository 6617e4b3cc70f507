// Readers of the matches with known relative pose, and the two errors by which a pose is judged.
#pragma once

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "fsw/vision/twoview/two_view.hpp"

namespace ilp::test {

struct PoseCase {
  std::string name;
  CameraModel camera;
  RigidTransform truth;  ///< |t| = 1
  PointPairs pairs;
  std::vector<int> inlier;  ///< truth
};

inline constexpr double degrees = 180 / 3.14159265358979323846;

inline double rotation_error_deg(const RigidTransform& estimate, const RigidTransform& truth) {
  return degrees * rotation_angle(estimate.rotation.transpose() * truth.rotation);
}

inline double direction_error_deg(const RigidTransform& estimate, const RigidTransform& truth) {
  const Vec3 a = estimate.translation.normalized();
  const Vec3 b = truth.translation.normalized();
  return degrees * std::atan2(a.cross(b).norm(), a.dot(b));
}

inline double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return 0.5 * (values[(n - 1) / 2] + values[n / 2]);
}

/// Lines that are not comments, numbers one after the other.
inline std::vector<double> read_numbers(const std::string& path) {
  std::ifstream file(path);
  std::vector<double> numbers;
  std::string line;
  while (std::getline(file, line)) {
    if (!line.empty() && line[0] == '#') continue;
    std::istringstream words(line);
    double value = 0;
    while (words >> value) numbers.push_back(value);
  }
  return numbers;
}

inline void append_matches(const std::vector<double>& numbers, std::size_t first, PoseCase& result) {
  for (std::size_t i = first; i + 4 < numbers.size() && !result.pairs.full(); i += 5) {
    static_cast<void>(result.pairs.push_back({numbers[i], numbers[i + 1], numbers[i + 2], numbers[i + 3], 0.0F}));
    result.inlier.push_back(static_cast<int>(numbers[i + 4]));
  }
}

inline RigidTransform read_pose(const double* numbers) {
  RigidTransform pose;
  for (int i = 0; i < 9; ++i) pose.rotation(i / 3, i % 3) = numbers[i];
  pose.translation = Vec3(numbers[9], numbers[10], numbers[11]).normalized();
  return pose;
}

/// relative_pose_synthetic: R, t, then matches; f = 700 px, 640x480.
inline bool read_synthetic(const std::string& path, PoseCase& result) {
  const std::vector<double> numbers = read_numbers(path);
  if (numbers.size() < 12 + 5) return false;
  result = {};
  result.name = path;
  result.camera.width = 640;
  result.camera.height = 480;
  result.camera.fx = result.camera.fy = 700;
  result.camera.cx = 319.5;
  result.camera.cy = 239.5;
  result.truth = read_pose(numbers.data());
  append_matches(numbers, 12, result);
  return true;
}

/// relative_pose_strecha: K1, K2 (equal), R, t, baseline, count, then matches.
inline bool read_strecha(const std::string& path, PoseCase& result) {
  const std::vector<double> numbers = read_numbers(path);
  if (numbers.size() < 22 + 5) return false;
  result = {};
  result.name = path;
  result.camera.width = 768;
  result.camera.height = 512;
  result.camera.fx = numbers[0];
  result.camera.fy = numbers[1];
  result.camera.cx = numbers[2];
  result.camera.cy = numbers[3];
  result.truth = read_pose(numbers.data() + 8);
  append_matches(numbers, 22, result);
  return true;
}

}  // namespace ilp::test
