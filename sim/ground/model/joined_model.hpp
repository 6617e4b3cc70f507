// One model of all strips whose keyframes show the same ground. The flight's links begin it; the ground matches again
// where images came down, first along the links, then wherever the model itself predicts common ground, and adjusts all
// poses and points together (docs/one-map.md, "One model on the ground").
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

/// Two keyframes that the flight has linked, and how far points of the earlier one are projected from where the newer
/// one sees them, median, px.
struct ClosedLink {
  std::int64_t place_id = 0, keyframe_id = 0;
  std::int64_t place_strip_id = 0, strip_id = 0;
  std::size_t points = 0;  ///< of the model, seen by both
  double before_px = 0;    ///< by the poses of the flight; 0: in two strips, or no such points
  double after_px = 0;     ///< in the model
};

/// How far the heights of different passes differ where they have depths of the same ground (height_steps.hpp), % of
/// the flying height.
struct HeightSteps {
  std::size_t samples = 0;  ///< pixels that were compared
  std::size_t pairs = 0;    ///< of keyframes
  double median_percent = 0, p95_percent = 0;
};

/// A model on the map of an orbiter, by the fixes of its keyframes.
struct OnMap {
  intake::MapPlace map;
  struct Fix {
    std::int64_t keyframe_id = 0;
    double sigmas = 0;  ///< norm of its six errors in the model, in stated ones
    bool used = true;   ///< false: it contradicts the others and the images, and moves nothing
  };
  std::vector<Fix> fixes;  ///< by keyframe
  std::size_t used = 0;
  double error_factor = 1;  ///< errors of the fixes for a stated one, by how well neighbours agree; 1 or more
  double image_factor = 1;  ///< how much more the images bend the model than their sightings state; 1 or more
  /// Distances of the cameras from where all fixes of a strip put it as a whole: the drift that they have removed.
  host::ErrorSummary removed_m;
};

struct JoinedModel {
  std::int64_t strip_id = 0;         ///< in whose world it stands, and under whose number its keyframes are shown
  std::vector<std::int64_t> strips;  ///< of its keyframes, by id
  struct Member {
    std::int64_t keyframe_id = 0, strip_id = 0;  ///< strip as the flight states it
    bool posed_by_flight = false;
    RigidTransform camera_from_strip;                  ///< as the flight states it, where it is posed by it
    double depth_scale = 1;                            ///< units of the strip for a unit of the depths as sent
    Vec3 before = Vec3::Zero(), after = Vec3::Zero();  ///< camera centres; `before` in its own strip's world
    /// 0, or the only keyframe that shares ground with it, whose depths tell how far away it stands
    /// (single_link_views.hpp).
    std::int64_t attached_to = 0;
  };
  std::vector<Member> members;  ///< by keyframe
  std::size_t points = 0, sightings = 0;
  double median_error_px = 0;
  std::optional<OnMap> on_map;  ///< none: it stands in the world of `strip_id`
  bool by_ties = false;         ///< some strip stands where the flight's tie puts it, because too few images came down
  std::vector<ClosedLink> links;
  HeightSteps steps_before;  ///< by the poses of the flight and its ties
  HeightSteps steps_after;   ///< in the model
};

struct StripApart {
  std::int64_t strip_id = 0;
  std::size_t keyframes = 0;
  std::string why;
};

struct JoinedFlight {
  std::vector<JoinedModel> models;
  std::vector<StripApart> apart;  ///< strips with keyframes in no model
};

/// Called with the phase that begins.
using JoinProgress = std::function<void(const std::string&)>;

/// Moves poses, points and depths of `flight` into the models, and the keyframes to the strip that names the model.
/// Models with fixes on a map become one model that stands on it (map_fixes.hpp). Does nothing where neither a link
/// nor three such fixes came down. The result depends on what came down only: `results`, which may be null, keeps
/// what follows from images alone, and adjustments, and changes the time only.
[[nodiscard]] JoinedFlight join_strips(intake::Flight& flight, const JoinProgress& progress,
                                       intake::ResultCache* results = nullptr);

}  // namespace ilp::model
