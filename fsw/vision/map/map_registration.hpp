// Finds where a keyframe stands on a map: the keyframe is drawn on the map's grid by its prior pose, pieces of it are
// each sought in a window, and they vote (docs/map-relative.md). Wrong answers must not happen; no answer may.
//
// Senses: the map's image under the sun of the moment (`relit`), the map's heights under that sun (`shape`), and the
// keyframe's own relief against the map's (`relief`), which has no light in it.
#pragma once

#include <span>

#include "fsw/base/result.hpp"
#include "fsw/vision/map/map_plan.hpp"
#include "fsw/vision/map/map_window.hpp"

namespace ilp {

struct MapRegistrationParams {
  double sun_limit_rad = 1.05;   ///< beyond it the image's bright sides are on the other side of what casts them
  double ambient = 0.25;         ///< share of the light on level ground that comes from the whole sky
  double min_evidence = 10;      ///< ground that is not there has had up to 6.5
  double rival_factor = 2.5;     ///< votes over those that agree on any other shift: ground that repeats
  double patch_sigma_px = 0.5;   ///< of a patch's place: heights of a map err together
  double common_sigma_px = 0.1;  ///< of all patches together, added to each axis
  double sanity_sigmas = 4;      ///< of the prior, which rotation and height may differ by
  bool use_relit = true, use_shape = true;
};

/// Depths of the keyframe along the optical axis, m; 0: none. Sample (i, j) is that of the pixel
/// (first_px + i step_px, first_px + j step_px).
struct KeyframeDepths {
  ImageView<const float> depth_m;
  double first_px = 0, step_px = 1;
};

struct MapRegistrationWorkspace;  // map_workspace.hpp

/// One registration in slices. It borrows what begin() gets until it is done. Slices are a few milliseconds each.
class MapRegistration {
 public:
  /// By light. `keyframes` (at least one; the first is that of the prior) are registered together.
  /// `invalid_argument`: map_window (sizes and numbers of the window and of its plan), map_keyframe, camera.
  Status begin(const MapPlan& plan, const MapWindow& window, const MapPrior& prior,
               std::span<const MapKeyframe> keyframes, const SunDirection& sun, const MapRegistrationParams& params,
               MapRegistrationWorkspace& workspace);
  /// By relief: the window's pixel is the distance of its posts; its image is not used.
  Status begin_relief(const MapPlan& plan, const MapWindow& window, const MapPrior& prior, const MapKeyframe& keyframe,
                      const KeyframeDepths& depths, const MapRegistrationParams& params,
                      MapRegistrationWorkspace& workspace);
  /// One slice. False when the result is there.
  Result<bool> step();
  [[nodiscard]] const MapFixResult& result() const { return result_; }

 private:
  MapFixResult result_;
};

}  // namespace ilp
