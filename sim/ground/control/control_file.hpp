// The file of ground control points: comma-separated values with a line of names.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "fsw/vision/geometry/types.hpp"

namespace ilp::control {

struct Mark {
  std::string image;          ///< file name, with or without its extension
  Vec2 pixel = Vec2::Zero();  ///< of the image as it flew, pixel centres at integers
};

struct ControlPoint {
  std::string name;
  Vec3 place = Vec3::Zero();  ///< x, y, height in metres, or longitude and latitude in degrees and height in metres
  double sigma_m = 0;
  bool check = false;  ///< only measured, not used
  std::vector<Mark> marks;
};

struct ControlFile {
  bool geographic = false;  ///< longitude and latitude
  std::vector<ControlPoint> points;
};

/// The first line is `name,x,y,height,sigma,role` or `name,longitude,latitude,height,sigma,role`. Each line after it
/// has these six values (role: control or check) and three for each image that shows the point: image, column, row. `#`
/// begins a comment. std::runtime_error names the line and what is wrong.
[[nodiscard]] ControlFile read_control_file(const std::filesystem::path& path);

}  // namespace ilp::control
