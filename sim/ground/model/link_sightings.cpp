#include "sim/ground/model/link_sightings.hpp"

#include <Eigen/LU>
#include <cmath>
#include <map>
#include <tuple>

#include "fsw/vision/geometry/camera.hpp"

namespace ilp::model {
namespace {

constexpr double same_ground_px = 3;

/// Linear part of a homography at a point.
bool linear_at(const double (&h)[9], const Vec2& at, Eigen::Matrix2d& linear) {
  const double w = h[6] * at.x() + h[7] * at.y() + h[8];
  const double u = (h[0] * at.x() + h[1] * at.y() + h[2]) / w, v = (h[3] * at.x() + h[4] * at.y() + h[5]) / w;
  linear << (h[0] - u * h[6]) / w, (h[1] - u * h[7]) / w, (h[3] - v * h[6]) / w, (h[4] - v * h[7]) / w;
  return linear.allFinite() && std::fabs(linear.determinant()) > 1e-3;
}

class LinkedPoints {
 public:
  explicit LinkedPoints(Scene& scene) : scene_(scene) {}

  void add(std::uint32_t a, const Vec2& in_a, std::uint32_t b, const Vec2& in_b, const Eigen::Matrix2d& b_from_a) {
    if (!is_about(a, in_a) || !is_about(b, in_b)) return;
    const bool taken = move_over(a, in_a, b, in_b, b_from_a);
    const bool returned = move_over(b, in_b, a, in_a, b_from_a.inverse());
    if (taken || returned) return;
    const auto key =
        std::tuple(a, std::lround(in_a.x() * link_points_per_px), std::lround(in_a.y() * link_points_per_px));
    const auto [known, fresh] = own_.try_emplace(key, scene_.tracks.size());
    if (fresh) scene_.tracks.push_back({false, 0, Vec3::Zero(), {}});
    see(known->second, a, in_a);
    see(known->second, b, in_b);
  }

 private:
  [[nodiscard]] Sighting sighting_at(std::uint32_t view, const Vec2& px) const {
    const Vec2 ideal = ideal_from_pixel(scene_.views[view].camera, px);
    return {view, ideal.x(), ideal.y()};
  }

  /// In the view's image or as far from it as it is wide: where a link's map is none, points go anywhere.
  [[nodiscard]] bool is_about(std::uint32_t view, const Vec2& px) const {
    const CameraModel& camera = scene_.views[view].camera;
    return px.x() > -camera.width && px.x() < 2 * camera.width && px.y() > -camera.height && px.y() < 2 * camera.height;
  }

  /// The sighting is a corner of its view from now on: other links find it, and images are matched there.
  void see(std::size_t track, std::uint32_t view, const Vec2& px) {
    if (scene_.sighting(scene_.tracks[track], view) != nullptr) return;
    scene_.tracks[track].seen.push_back(sighting_at(view, px));
    const Corner corner{static_cast<float>(px.x()), static_cast<float>(px.y()), 1};
    static_cast<void>(add_corner(corner, static_cast<std::int32_t>(track), scene_.views[view]));
  }

  /// A point that view `from` sees there is seen by view `to` as well.
  bool move_over(std::uint32_t from, const Vec2& at, std::uint32_t to, const Vec2& there,
                 const Eigen::Matrix2d& to_from_from) {
    const View& view = scene_.views[from];
    std::int32_t nearest = -1;
    Vec2 offset = Vec2::Zero();
    double distance = same_ground_px;
    for (std::size_t i = 0; i < view.corners.size(); ++i) {
      const Vec2 between = Vec2(view.corners[i].x, view.corners[i].y) - at;
      if (view.track_of_corner[i] < 0 || between.norm() >= distance) continue;
      distance = between.norm();
      nearest = view.track_of_corner[i];
      offset = between;
    }
    const Vec2 moved = there + to_from_from * offset;
    if (nearest < 0 || !is_about(to, moved)) return false;
    see(static_cast<std::size_t>(nearest), to, moved);
    return true;
  }

  Scene& scene_;
  std::map<std::tuple<std::uint32_t, long, long>, std::size_t> own_;  ///< tracks that began here, by place
};

}  // namespace

void add_link_sightings(const intake::Flight& flight, Scene& scene) {
  LinkedPoints linked(scene);
  for (const LinkRecord& link : flight.links) {
    const std::int32_t place = scene.view_of(link.place_id), newer = scene.view_of(link.keyframe_id);
    const auto points = flight.link_points.find(link.id);
    if (place < 0 || newer < 0 || place == newer || points == flight.link_points.end()) continue;
    for (const LinkPoint& point : points->second) {
      const Vec2 in_place(point.place_x / link_points_per_px, point.place_y / link_points_per_px);
      const Vec2 in_newer(point.x / link_points_per_px, point.y / link_points_per_px);
      Eigen::Matrix2d linear;
      if (!linear_at(link.keyframe_from_place_px, in_place, linear)) continue;
      linked.add(static_cast<std::uint32_t>(place), in_place, static_cast<std::uint32_t>(newer), in_newer, linear);
    }
  }
}

}  // namespace ilp::model
