// Interpolates depths in keyframes from the points that these see.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "sim/ground/model/scene.hpp"

namespace ilp::model {

/// Positions of tracks and poses of views in one world. The functions return null for a track or view that is not in
/// it.
struct World {
  std::function<const Vec3*(std::size_t)> point;
  std::function<const RigidTransform*(std::uint32_t)> pose;
};

class ViewDepths {
 public:
  ViewDepths(const Scene& scene, const World& world);

  /// Inverse depth at an ideal pixel as weighted mean of the points within 40 px; none if there are no such points.
  [[nodiscard]] std::optional<double> near(std::uint32_t view, double x, double y) const;
  /// Inverse depth at an ideal pixel on a plane through all points of the view; it is linear in the pixel. None if the
  /// relief is above 5 %. If the image is narrower than the focal length, this limit is reduced by the ratio of width
  /// to focal length, because a narrow field of view makes any ground look flat.
  [[nodiscard]] std::optional<double> plane(std::uint32_t view, double x, double y) const;
  /// Median relative deviation of the view's inverse depths from the plane; none if there is no plane.
  [[nodiscard]] std::optional<double> relief(std::uint32_t view) const;
  /// near(), or plane() if that has none.
  [[nodiscard]] std::optional<double> any(std::uint32_t view, double x, double y) const;

 private:
  struct InverseDepth {
    double x = 0, y = 0, value = 0;
  };
  struct Plane {
    bool fitted = false;
    std::optional<Vec3> plane = std::nullopt;
    double relief = 0;
  };
  static Plane plane_through(const std::vector<InverseDepth>& depths, double most);
  const Plane& plane_of(std::uint32_t view) const;

  std::vector<std::vector<InverseDepth>> depths_;  ///< for each view, inverse depths of the points that it sees
  std::vector<double> most_relief_;                ///< for each view, largest relief with a plane
  mutable std::vector<Plane> planes_;              ///< for each view, fitted on demand, because few are needed
};

}  // namespace ilp::model
