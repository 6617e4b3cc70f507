// The file of ground control points: a table with a line of names, or the gcp_list.txt of OpenDroneMap.
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
  bool geographic = false;       ///< longitude and latitude
  std::string system;            ///< coordinate system of x and y, for GDAL; empty: none is stated
  bool original_pixels = false;  ///< marks are in the photographs as they came, whatever size flew
  std::vector<ControlPoint> points;
};

/// The first line is `name,x,y,height,sigma,role` or `name,longitude,latitude,height,sigma,role`, in capitals or not.
/// Each line after it has these six values (role: control or check) and three for each image that shows the point:
/// image, column, row. `#` begins a comment. Tables of spreadsheets are read (host/cell_file.hpp), and empty cells at
/// the end of a line fall away.
///
/// Read too: ODM's gcp_list.txt. Its first line is the coordinate system (`EPSG:32633`, `WGS84 UTM 33N` or
/// `+proj=...`), each further one `x y height column row image [name]`. Marks with one name, or with the same place,
/// are one point. It states no errors: sigma is `assumed_sigma_m`. std::runtime_error names the line and what is wrong.
[[nodiscard]] ControlFile read_control_file(const std::filesystem::path& path);

inline constexpr double assumed_sigma_m = 0.05;

}  // namespace ilp::control
