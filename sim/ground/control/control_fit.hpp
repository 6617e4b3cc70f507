// Control points from their marks in images, and the similarity that brings them to where they were surveyed.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "fsw/vision/geometry/similarity.hpp"
#include "sim/host/alignment.hpp"

namespace ilp::control {

/// One camera that shows a point.
struct Sight {
  CameraModel camera;
  Mat3 cam_from_world = Mat3::Identity();
  Vec3 centre = Vec3::Zero();
  Vec2 pixel = Vec2::Zero();
};

struct Triangulated {
  Vec3 point = Vec3::Zero();
  Mat3 covariance = Mat3::Zero();  ///< for marks of one pixel; square world units
  double rms_px = 0;               ///< of the marks against the point
};
/// The point nearest to the lines of sight in pixels. None for fewer than two sights, for lines that are nearly
/// parallel and for a point behind a camera.
[[nodiscard]] std::optional<Triangulated> triangulate(const std::vector<Sight>& sights);

struct Surveyed {
  Vec3 world = Vec3::Zero();  ///< triangulated
  Mat3 world_covariance = Mat3::Zero();
  Vec3 place = Vec3::Zero();  ///< surveyed, metres
  double place_sigma = 0;
  bool usable = true;  ///< false: only measured
};

struct ControlFit {
  host::Similarity3 place_from_world;
  std::vector<bool> used;        ///< of each point
  std::vector<Vec3> residual;    ///< place by the fit minus surveyed place, metres
  std::vector<double> expected;  ///< one sigma of the residual that survey and marks explain, metres
};

/// Three points or more that agree: all triples are tried (of the first 40 points), a point agrees within four sigmas,
/// and the largest agreeing set is fitted by least squares, each point with its covariance. None where no triple is
/// usable; points on one line do not determine the turn about it, and are refused.
[[nodiscard]] std::optional<ControlFit> fit_control(const std::vector<Surveyed>& points);

}  // namespace ilp::control
