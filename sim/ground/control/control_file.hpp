// Reads a file of ground control points: a table with a line of names, or the gcp_list.txt of OpenDroneMap.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "fsw/vision/geometry/types.hpp"

namespace ilp::control {

struct Mark {
  std::string image;          ///< file name, with or without its extension
  Vec2 pixel = Vec2::Zero();  ///< column and row, pixel centres at integers (ControlFile::original_pixels)
};

struct ControlPoint {
  std::string name;
  Vec3 place = Vec3::Zero();  ///< x, y, height in metres, or longitude and latitude in degrees and height in metres
  double sigma_m = 0;         ///< standard deviation of each coordinate
  bool check = false;         ///< a check point: measured, but not used to place strips
  std::vector<Mark> marks;
};

struct ControlFile {
  bool geographic = false;       ///< points have longitude and latitude, not x and y
  std::string system;            ///< coordinate system of x and y, for GDAL; empty: not stated
  bool original_pixels = false;  ///< marks are in pixels of the original photographs; false: of the flight's images
  std::vector<ControlPoint> points;
};

/// Reads either format. The first line of a table is `name,x,y,height,sigma,role` or
/// `name,longitude,latitude,height,sigma,role`, in upper or lower case. Each further line has these six values (role:
/// control or check), and three more for each image that shows the point: image, column, row. `#` begins a comment.
/// Tables of spreadsheets are accepted (host/cell_file.hpp); empty cells at the end of a line are ignored.
///
/// The first line of ODM's gcp_list.txt is the coordinate system (`EPSG:32633`, `WGS84 UTM 33N` or `+proj=...`). Each
/// further line is `x y height column row image [name]`. Marks with the same name, or the same position, are one point.
/// The file states no errors, so that sigma is `assumed_sigma_m`. Throws std::runtime_error that names the line and
/// says what is wrong.
[[nodiscard]] ControlFile read_control_file(const std::filesystem::path& path);

inline constexpr double assumed_sigma_m = 0.05;

}  // namespace ilp::control
