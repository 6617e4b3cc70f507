// Joins strips whose keyframes show the same ground into one model. It starts from the flight's links. Where images
// came down, the ground matches them again, first along the links, then wherever the model predicts common ground. Then
// it adjusts all poses and points together (docs/one-map.md, "One model on the ground").
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/intake/result_cache.hpp"
#include "sim/host/statistics.hpp"

namespace ilp::model {

/// Two keyframes that the flight has linked, with median reprojection errors of their common points in the newer one.
struct ClosedLink {
  std::int64_t place_id = 0, keyframe_id = 0;     ///< earlier and newer keyframe
  std::int64_t place_strip_id = 0, strip_id = 0;  ///< their strips in the flight
  std::size_t points = 0;                         ///< points of the model that both see
  double before_px = 0;                           ///< by the poses of the flight; 0: in two strips, or no such points
  double after_px = 0;                            ///< in the model
};

/// Height differences between passes over the same ground, in % of the depth (height_steps.hpp).
struct HeightSteps {
  std::size_t samples = 0;  ///< number of compared pixels
  std::size_t pairs = 0;    ///< number of compared pairs of keyframes
  double median_percent = 0, p95_percent = 0;
};

/// How the fixes of its keyframes place a model on an orbiter's map.
struct OnMap {
  intake::MapPlace map;
  struct Fix {
    std::int64_t keyframe_id = 0;
    double sigmas = 0;  ///< norm of its six normalised residuals in the model (fix_errors)
    bool used = true;   ///< false: an outlier against the other fixes and the images, without effect
  };
  std::vector<Fix> fixes;   ///< in the order of the keyframe ids
  std::size_t used = 0;     ///< number of used fixes
  double error_factor = 1;  ///< as in FixWeights (model.hpp); 1 or more
  double image_factor = 1;  ///< as in FixWeights; 1 or more
  /// Drift that the fixes have removed: distances of the camera centres from where a similarity of the model as a whole
  /// had put them.
  host::ErrorSummary removed_m;
};

struct JoinedModel {
  std::int64_t strip_id = 0;         ///< strip whose world the model has, and whose id its keyframes get
  std::vector<std::int64_t> strips;  ///< ids of the strips that its keyframes were in, ascending
  struct Member {
    std::int64_t keyframe_id = 0, strip_id = 0;  ///< the strip is that of the flight
    bool posed_by_flight = false;
    RigidTransform camera_from_strip;  ///< the flight's pose; valid if posed_by_flight
    double depth_scale = 1;            ///< Keyframe::depth_scale in the strip's world
    /// Camera centre by the flight in its strip's world, and in the model.
    Vec3 before = Vec3::Zero(), after = Vec3::Zero();
    /// The only keyframe that shares ground with a single-link view, and whose depths give its distance
    /// (single_link_views.hpp); 0: not a single-link view.
    std::int64_t attached_to = 0;
  };
  std::vector<Member> members;  ///< in the order of the keyframe ids
  std::size_t points = 0, sightings = 0;
  double median_error_px = 0;   ///< median reprojection error
  std::optional<OnMap> on_map;  ///< none: the model is in the world of `strip_id`
  bool by_ties = false;         ///< the flight's tie alone places some strip, because too few images came down
  std::vector<ClosedLink> links;
  HeightSteps steps_before;  ///< by the poses of the flight and its ties
  HeightSteps steps_after;   ///< in the model
};

/// A strip with keyframes outside all models.
struct StripApart {
  std::int64_t strip_id = 0;
  std::size_t keyframes = 0;  ///< number of these keyframes
  std::string why;            ///< in words
};

struct JoinedFlight {
  std::vector<JoinedModel> models;
  std::vector<StripApart> apart;  ///< in the order of the strip ids
};

/// Called with the name of the phase that begins.
using JoinProgress = std::function<void(const std::string&)>;

/// Makes the models, and moves poses, points and depths of `flight` into them; each keyframe gets the strip id of its
/// model. Models with fixes on an orbiter's map become one model on that map (map_fixes.hpp). Does nothing if neither a
/// link nor three such fixes came down. `results` caches work on images and adjustments, and does not change the
/// result; it may be null.
[[nodiscard]] JoinedFlight join_strips(intake::Flight& flight, const JoinProgress& progress,
                                       intake::ResultCache* results = nullptr);

}  // namespace ilp::model
