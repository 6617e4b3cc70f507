// One model under construction: the views that stand in it, and the points that they see.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "fsw/vision/geometry/similarity.hpp"
#include "sim/ground/model/pose_errors.hpp"
#include "sim/ground/model/scene.hpp"

namespace ilp::model {

struct ModelView {
  bool in = false;
  RigidTransform camera_from_model;
  std::optional<PoseCovariance> covariance = std::nullopt;  ///< where state_errors() found it
  std::optional<std::uint32_t> attached_to =
      std::nullopt;  ///< the only view that shows its ground (single_link_views.hpp)
  int rung = 0;  ///< 0: two views measure where it stands; otherwise one more than that of the view it is attached to
};

struct ModelPoint {
  bool placed = false;
  Vec3 position = Vec3::Zero();
  bool by_depth = false;  ///< its views see it under too small an angle: depths of points near it help
};

/// Where a fix on the map puts a view. The errors are its own; that of the map's place is common to all.
struct ViewFix {
  std::uint32_t view = 0;
  Mat3 cam_from_map = Mat3::Identity();
  Vec3 centre = Vec3::Zero();             ///< m
  Mat6 sigmas_from_error = Mat6::Zero();  ///< of rotation vector in the camera's axes and centre: six errors of sigma 1
};

/// How fixes count against sightings.
struct FixWeights {
  double image_px = 1;      ///< error of sightings, px: what one sigma of a fix counts among them
  double image_factor = 1;  ///< part of it: how much more the model bends than independent sightings would let it
  double error_factor = 1;  ///< errors of the fixes for a stated one
  double loss = 0;          ///< scale of Cauchy's loss of a fix, in its errors
};

struct Model {
  std::vector<ModelView> views;       ///< by view of the scene
  std::vector<ModelPoint> points;     ///< by track of the scene
  std::vector<std::uint8_t> refused;  ///< sightings that contradict the others of their tracks, track after track
  std::vector<std::size_t> first;     ///< by track, of its sightings in `refused`; and the end
  bool by_sub_maps = false;           ///< adjusted in parts, and the errors of its views are stated
  std::vector<ViewFix> fixes;         ///< by view; with any, the model stands on their map (map_fixes.hpp)
  FixWeights fix_weights;             ///< of fixes

  [[nodiscard]] std::size_t size() const;
  [[nodiscard]] bool refuses(std::size_t track, std::size_t sighting) const {
    return refused[first[track] + sighting] != 0;
  }
  void refuse(std::size_t track, std::size_t sighting, bool yes) { refused[first[track] + sighting] = yes ? 1 : 0; }
  [[nodiscard]] bool sees(const Scene& scene, std::size_t track, std::size_t sighting) const {
    return views[scene.tracks[track].seen[sighting].view].in && !refuses(track, sighting);
  }
};

[[nodiscard]] Vec3 centre_of(const RigidTransform& camera_from_world);

/// The pose in the world `a` of a camera that has this one in the world `b`.
[[nodiscard]] RigidTransform moved(const Similarity& a_from_b, const RigidTransform& camera_from_b);

/// A model of one strip as the flight states it.
[[nodiscard]] Model model_of_strip(const Scene& scene, std::int64_t strip_id);
/// Gives new tracks and sightings of the scene their room.
void grow(const Scene& scene, Model& model);

/// Distance of a point's projection from where it was seen, ideal px; infinite behind the camera.
[[nodiscard]] double reprojection_error(const RigidTransform& camera_from_model, const CameraModel& camera,
                                        const Vec3& point, const Sighting& seen);

/// Triangulates the points that two or more views of the model see under an angle of a degree or more (linear least
/// squares; R. Hartley, A. Zisserman, "Multiple View Geometry", 12.2), unless a sighting is off by `max_px`. Others
/// stand where the depths about them put them in the first view that sees them (`by_depth`).
void triangulate(const Scene& scene, double max_px, Model& model);

/// Refuses the sightings that are off by more than `max_px`; points with fewer than two that are left are taken back.
void refuse_outliers(const Scene& scene, double max_px, Model& model);

/// What a model holds. An adjustment that changes none of it is the last one that is needed.
struct ModelExtent {
  std::size_t views = 0, sightings = 0, points = 0, refused = 0;
  double largest_error_px = 0;  ///< of the sightings that are not refused

  [[nodiscard]] bool same_parts(const ModelExtent& other) const {
    return views == other.views && sightings == other.sightings && points == other.points && refused == other.refused;
  }
};
[[nodiscard]] ModelExtent extent_of(const Scene& scene, const Model& model);

/// Median reprojection error, px.
[[nodiscard]] double median_error_px(const Scene& scene, const Model& model);

/// A model as the adjustment takes it.
struct ModelProblem : AdjustmentProblem {
  std::vector<std::size_t> view_of;   ///< by camera
  std::vector<std::size_t> track_of;  ///< by point
};
[[nodiscard]] ModelProblem problem_of(const Scene& scene, const Model& model);

/// Scale of Cauchy's loss in the last adjustment.
inline constexpr double last_robust_px = 0.5;

/// Bundle adjustment of the whole model (adjustment.hpp), with its fixes as priors. Points that stand by the depths
/// about them keep these within a hundredth. `tolerance`: as in AdjustmentParams.
void adjust_model(const Scene& scene, double robust_px, Model& model, double tolerance = AdjustmentParams{}.tolerance);

/// The covariances of the views (pose_errors.hpp), as the model stands now, larger by what neighbouring sightings have
/// in common (common_errors.hpp). Where sightings alone leave something free, each view knows a distance within a
/// hundredth.
void state_errors(const Scene& scene, Model& model);

/// Moves all views and points.
void move(const Similarity& by, Model& model);

}  // namespace ilp::model
