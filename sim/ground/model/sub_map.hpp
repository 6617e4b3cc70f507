// A part of a long flight, adjusted on its own.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sim/ground/model/camera_system.hpp"
#include "sim/ground/model/common_errors.hpp"
#include "sim/ground/model/model.hpp"
#include "sim/ground/model/sub_map_plan.hpp"

namespace ilp::model {

struct SubMapCamera {
  std::uint32_t view = 0;
  RigidTransform camera_from_map;
  Vec6 right = Vec6::Zero();  ///< of the equations
};

/// Half the squares of what the sub-map sees, as its cameras move by `m` (rotation vector in their axes and centre,
/// where the map has them), with their points: m . A m / 2 - right . m, and a constant. Where the map as a whole
/// is turned, moved or has another scale, nothing changes.
struct SubMap {
  std::vector<SubMapCamera> cameras;  ///< by view
  std::vector<CameraBlock> blocks;    ///< of A; rows and columns are places in `cameras`
  struct Refused {
    std::size_t track = 0, sighting = 0;
  };
  std::vector<Refused> refused;
  struct Point {
    std::size_t track = 0;
    bool by_depth = false;
    Vec3 position = Vec3::Zero();
  };
  std::vector<Point> points;  ///< those that are placed, in the map's world
  // The squares of its residuals, how much robust weights lessen them in A, and how many there are more than points
  // have unknowns.
  double squares = 0, weight = 1, redundancy = 0;
  CommonErrors common;  ///< of its residuals
};

/// Adjusts the views and tracks of the plan alone, of which those that support it leave no residuals in the result,
/// from the flight's poses, with bounds as those of a whole model. It depends on nothing else in the scene, and what
/// was once adjusted is taken from the scene's results. None where too few views find a place.
[[nodiscard]] std::optional<SubMap> adjusted_sub_map(const Scene& scene, const SubMapPlan& plan);

}  // namespace ilp::model
