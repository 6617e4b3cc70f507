// Adjusts a part of a long flight by itself (a sub-map), and reduces it to equations of its cameras.
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
  Vec6 right = Vec6::Zero();  ///< right side of the equations
};

/// An adjusted sub-map. If its cameras move by `m` (rotation vectors in their axes, and centres, from their poses in
/// the map), and the points follow, half the sum of squared residuals becomes m . A m / 2 - right . m plus a constant.
/// It does not change if the map as a whole is moved by a similarity.
struct SubMap {
  std::vector<SubMapCamera> cameras;  ///< in the order of the views
  std::vector<CameraBlock> blocks;    ///< blocks of A; rows and columns are indices in `cameras`
  struct Refused {
    std::size_t track = 0, sighting = 0;
  };
  std::vector<Refused> refused;  ///< outliers
  struct Point {
    std::size_t track = 0;
    bool by_depth = false;
    Vec3 position = Vec3::Zero();
  };
  std::vector<Point> points;  ///< placed points, in the map's world
  // Sum of the squared residuals; mean robust weight of the residuals in A; number of residuals minus unknowns of
  // points.
  double squares = 0, weight = 1, redundancy = 0;
  CommonErrors common;  ///< of the residuals
};

/// Adjusts the views and tracks of the plan, starting from the flight's poses, with the bounds of a whole model
/// (growth.hpp). Residuals of the supporting tracks are not in the result. The result depends on nothing else of the
/// scene, and is cached in the scene's results. None if fewer than two views can be placed.
[[nodiscard]] std::optional<SubMap> adjusted_sub_map(const Scene& scene, const SubMapPlan& plan);

}  // namespace ilp::model
