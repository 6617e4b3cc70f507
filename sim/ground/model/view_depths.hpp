// The depths that a world's points have in each of its keyframes, and what they say of the ground between and beside
// them.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "sim/ground/model/scene.hpp"

namespace ilp::model {

/// Points by track and poses by view; null: not in this world.
struct World {
  std::function<const Vec3*(std::size_t)> point;
  std::function<const RigidTransform*(std::uint32_t)> pose;
};

class ViewDepths {
 public:
  ViewDepths(const Scene& scene, const World& world);

  /// Inverse depth at an ideal pixel by the points within 40 px; none where there are none.
  [[nodiscard]] std::optional<double> near(std::uint32_t view, double x, double y) const;
  /// By a plane through all points of the view, if they lie within 5 % of one: its inverse depth is linear in pixels.
  /// Where the image is narrower than its focal length, within as much less: from far enough any ground looks flat.
  [[nodiscard]] std::optional<double> plane(std::uint32_t view, double x, double y) const;
  /// Median distance of the view's inverse depths from the plane, as a share of them; none where there is no plane.
  [[nodiscard]] std::optional<double> relief(std::uint32_t view) const;
  /// Near, or else by the plane.
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

  std::vector<std::vector<InverseDepth>> depths_;  ///< by view
  std::vector<double> most_relief_;                ///< by view, of points that a plane stands for
  mutable std::vector<Plane> planes_;              ///< fitted when they are asked for: most worlds never need them
};

}  // namespace ilp::model
