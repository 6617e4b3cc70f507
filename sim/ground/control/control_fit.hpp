// Triangulates control points from their marks in images, and fits the similarity that takes them to their surveyed
// positions.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "fsw/vision/geometry/similarity.hpp"
#include "sim/host/alignment.hpp"

namespace ilp::control {

/// A camera and the pixel in which it shows a point.
struct Sight {
  CameraModel camera;
  Mat3 cam_from_world = Mat3::Identity();
  Vec3 centre = Vec3::Zero();
  Vec2 pixel = Vec2::Zero();
};

struct Triangulated {
  Vec3 point = Vec3::Zero();
  Mat3 covariance = Mat3::Zero();  ///< for marks with a sigma of one pixel; square world units
  double rms_px = 0;               ///< RMS reprojection error of the marks
};
/// The point with the least squared distance from the lines of sight, in pixels. None for fewer than two sights, nearly
/// parallel lines (below 0.01 rad), and a point behind a camera.
[[nodiscard]] std::optional<Triangulated> triangulate(const std::vector<Sight>& sights);

struct Surveyed {
  Vec3 world = Vec3::Zero();  ///< triangulated position in the strip's world
  Mat3 world_covariance = Mat3::Zero();
  Vec3 place = Vec3::Zero();  ///< surveyed position, metres
  double place_sigma = 0;     ///< standard deviation of each surveyed coordinate, metres
  bool usable = true;         ///< false: gets a residual, but is not used for the fit
};

struct ControlFit {
  host::Similarity3 place_from_world;
  // One element for each point.
  std::vector<bool> used;        ///< an inlier of the fit
  std::vector<Vec3> residual;    ///< position by the fit minus surveyed position, metres
  std::vector<double> expected;  ///< sigma of the residual (3D) from the errors of survey and marks, metres
};

/// Fits the similarity to the largest set of three or more points that agree. Tries all triples of the first 40 usable
/// points; a point agrees if its residual is at most four sigmas. The set is fitted by least squares with the points'
/// covariances. Triples nearly on one line are not used, because they do not determine the rotation about it. None if
/// no triple gives three agreeing points.
[[nodiscard]] std::optional<ControlFit> fit_control(const std::vector<Surveyed>& points);

}  // namespace ilp::control
