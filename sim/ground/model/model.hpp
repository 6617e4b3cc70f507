// A model under construction: poses of the views that are in it, and the points that they see.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "fsw/vision/geometry/similarity.hpp"
#include "sim/ground/model/pose_errors.hpp"
#include "sim/ground/model/scene.hpp"

namespace ilp::model {

struct ModelView {
  bool in = false;  ///< the view is in the model
  RigidTransform camera_from_model;
  std::optional<PoseCovariance> covariance = std::nullopt;  ///< none: state_errors() has not determined it
  std::optional<std::uint32_t> attached_to =
      std::nullopt;  ///< the only view that shows its ground (single_link_views.hpp)
  /// Length of the chain of single links that the pose depends on; 0: it depends on none. A single-link view has 1 +
  /// the rung of the view that it is attached to. rung_by_points() gives the rung of a view that two or more views
  /// measure.
  int rung = 0;
};

struct ModelPoint {
  bool placed = false;  ///< `position` is valid
  Vec3 position = Vec3::Zero();
  bool by_depth = false;  ///< its views see it under too small an angle: the position is from depths of points near it
};

/// Pose of a view by a fix on the map. The errors are those of the fix alone; the error of the map's own position is
/// common to all fixes and not included.
struct ViewFix {
  std::uint32_t view = 0;
  Mat3 cam_from_map = Mat3::Identity();
  Vec3 centre = Vec3::Zero();  ///< m
  /// Whitens the error (rotation vector in the camera's axes, centre): six values of standard deviation 1.
  Mat6 sigmas_from_error = Mat6::Zero();
};

/// Weights of fixes against sightings.
struct FixWeights {
  double image_px = 1;      ///< error of a sighting with its factor, px: one sigma of a fix weighs as much
  double image_factor = 1;  ///< contained in image_px: bending of the model divided by what the sightings explain
  double error_factor = 1;  ///< true errors of the fixes divided by their estimated errors
  double loss = 0;          ///< scale of Cauchy's loss of a fix, in units of its errors
};

/// A model of a scene. Indices of views and tracks are those of the scene.
struct Model {
  std::vector<ModelView> views;       ///< one for each view of the scene
  std::vector<ModelPoint> points;     ///< one for each track of the scene
  std::vector<std::uint8_t> refused;  ///< for each sighting, track after track: not 0 if it is an outlier of its track
  std::vector<std::size_t> first;     ///< for each track, index of its first sighting in `refused`; and the end
  bool by_sub_maps = false;           ///< adjusted in sub-maps, and the covariances of its views are set
  std::vector<ViewFix> fixes;         ///< at most one for each view; not empty: the model is on the map (map_fixes.hpp)
  FixWeights fix_weights;

  /// Number of views in the model.
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

/// Transforms a pose from the world `b` to the world `a`.
[[nodiscard]] RigidTransform moved(const Similarity& a_from_b, const RigidTransform& camera_from_b);

/// A model with the poses and points of one strip by the flight.
[[nodiscard]] Model model_of_strip(const Scene& scene, std::int64_t strip_id);
/// Extends `points`, `refused` and `first` for new tracks and sightings of the scene.
void grow(const Scene& scene, Model& model);

/// Distance between the projection of a point and its sighting, ideal px; infinite if the point is behind the camera.
[[nodiscard]] double reprojection_error(const RigidTransform& camera_from_model, const CameraModel& camera,
                                        const Vec3& point, const Sighting& seen);

/// Places the points that are not placed yet and that two or more views of the model see. A point is triangulated if
/// its lines of sight cross at a degree or more (linear least squares; R. Hartley, A. Zisserman, "Multiple View
/// Geometry", 12.2). Otherwise it gets the depth of points near it in the first view that sees it (`by_depth`). A point
/// with a reprojection error of `max_px` or more is not placed.
void triangulate(const Scene& scene, double max_px, Model& model);

/// Refuses sightings with a reprojection error above `max_px`, and accepts the others. Removes points with fewer than
/// two accepted sightings.
void refuse_outliers(const Scene& scene, double max_px, Model& model);

/// Size of a model. If an adjustment does not change it, no other adjustment is needed.
struct ModelExtent {
  /// `sightings`: all in views of the model; `refused`: those that are refused or have no placed point.
  std::size_t views = 0, sightings = 0, points = 0, refused = 0;
  double largest_error_px = 0;  ///< largest reprojection error of the other sightings

  [[nodiscard]] bool same_parts(const ModelExtent& other) const {
    return views == other.views && sightings == other.sightings && points == other.points && refused == other.refused;
  }
};
[[nodiscard]] ModelExtent extent_of(const Scene& scene, const Model& model);

/// Median reprojection error of the sightings that are not refused, px; 0 without any.
[[nodiscard]] double median_error_px(const Scene& scene, const Model& model);

/// An adjustment problem made from a model.
struct ModelProblem : AdjustmentProblem {
  std::vector<std::size_t> view_of;   ///< for each camera, its view
  std::vector<std::size_t> track_of;  ///< for each point, its track
};
[[nodiscard]] ModelProblem problem_of(const Scene& scene, const Model& model);

/// Scale of Cauchy's loss in the last adjustment.
inline constexpr double last_robust_px = 0.5;

/// Bundle adjustment of the whole model (adjustment.hpp), with its fixes as priors. Points placed by depth
/// (ModelPoint::by_depth) keep it with a relative sigma of 1 %. `robust_px`, `tolerance`: as in AdjustmentParams.
void adjust_model(const Scene& scene, double robust_px, Model& model, double tolerance = AdjustmentParams{}.tolerance);

/// Sets the covariances of the views in the model's current state (pose_errors.hpp), enlarged for correlated errors of
/// neighbouring sightings (common_errors.hpp). If the sightings do not determine all poses, each view gets a depth with
/// a relative sigma of 1 % in addition.
void state_errors(const Scene& scene, Model& model);

/// Moves all views and points by the similarity.
void move(const Similarity& by, Model& model);

}  // namespace ilp::model
