// Structure and motion of one strip, keyframe by keyframe, with known intrinsics (paper 3.2; decisions.md, 4, 5, 7).
//
// For every keyframe, matches to the previous one, or to one a little older, extend tracks. A pair of the first five
// keyframes begins the structure; every other camera is resected from the tracks' points (P3P in RANSAC, then
// non-linear); new points are triangulated; a bundle adjustment refines the window's cameras and points while older
// cameras stay fixed. A camera is *final* when it leaves the window, and never changes again; so is a point that only
// final cameras see.
//
// World: the first camera is at the origin and looks straight down the z axis (its x is world x, its y is world -y),
// unless the caller knows its attitude.
// The unit is the distance from the first camera to the second one, or to the first one with a baseline
// (FirstPair::scale_camera); when the caller knows the height over ground, it sets the scale.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/status.hpp"
#include "fsw/base/verdicts.hpp"
#include "fsw/vision/features/feature_types.hpp"
#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"
#include "fsw/vision/multiview/first_pair.hpp"
#include "fsw/vision/multiview/resection.hpp"
#include "fsw/vision/multiview/sequence_covariance.hpp"
#include "fsw/vision/multiview/track.hpp"
#include "fsw/vision/twoview/two_view.hpp"

namespace ilp {

struct SequenceParams {
  std::uint32_t window_keyframes = 5;  ///< paper 3.2.2; 2 to limits::max_window_keyframes
  RansacParams two_view;               ///< its seed is mixed with that of the keyframe
  double resection_threshold_px = 1.0;
  /// The errors of matches have heavy tails, in real images and in rendered ones: no bound separates errors of several
  /// sigmas from good matches. Cauchy's function gives them little weight, Huber's does not.
  double robust_px = 0.5;  ///< scale of the loss, and bound of Huber's in the resection
  /// Stated position errors are those of the matches' scatter times this factor. Registration errors that all matches
  /// of an image share leave no residual: on rendered relief under a low sun they are 0.02 to 0.04 px and smooth over
  /// the image, on a rendered plane they are zero. One factor for all axes and lengths is a bound, not a model: over 60
  /// straight keyframes (sim/campaigns/straight.ini) errors along the track need a factor of 1.7, in height 2 to 2.7,
  /// across the track 4 to 5.5, all together 3; over a plane 1 is enough.
  double error_factor = 3;
  /// Of the intrinsics, lower triangle in the order of Intrinsic; 0 for a camera that is known exactly. Estimated
  /// errors of poses contain what it does to them.
  std::array<double, intrinsic_count*(intrinsic_count + 1) / 2> lens_covariance{};
  /// The structure begins as soon as a pair promises depths with at most this relative error (expected_depth_error). If
  /// no pair does, the best one begins when max_first_keyframes have come, or at the end of the strip.
  double max_first_depth_error = 0.2;
  double first_height =
      0;  ///< > 0: median depth of the first pair's points, which sets the scale; 0: its baseline is 1
  /// Attitude of the first camera, unit quaternion w, x, y, z. The default looks straight down, its x is world x.
  double q_first[4] = {0, 1, 0, 0};
  double max_tilt_step_rad = 0.7;  ///< between the optical axes of consecutive keyframes
  /// (Baseline - way around what the camera looks at by the tilt) / extent of an image on the ground.
  double max_step_footprints = 1.5;
};

/// The two-view estimate of the previous keyframe and this one: the fields of TwoViewResult without the pose.
struct PairReport {
  TwoViewVerdict verdict = TwoViewVerdict::too_few_inliers;
  std::uint32_t inliers = 0;
  double gric_e = 0, gric_h = 0;
  double median_parallax_px = 0;
  double rms_px = 0;
  double sigma_rotation_rad = 0;
  double sigma_direction_rad = 0;
};

/// The result of one keyframe.
struct SequenceReport {
  SequenceVerdict verdict = SequenceVerdict::waiting;
  PairReport two_view;
  std::uint32_t matches = 0;
  std::uint32_t known_points = 0;  ///< matches with points of the structure, for the resection
  std::uint32_t resection_inliers = 0;
  std::uint32_t points = 0;                ///< seen by this keyframe
  std::uint32_t new_points = 0;            ///< triangulated at this keyframe
  std::uint32_t dropped_observations = 0;  ///< outliers after bundle adjustment
  std::uint32_t lost_points = 0;           ///< left with fewer than two observations
  std::uint32_t bundle_points = 0;
  std::uint32_t bundle_observations = 0;
  std::uint32_t bundle_iterations = 0;
  std::uint32_t refused_tracks = 0;     ///< the table was full: new tracks not begun
  std::uint32_t evicted_tracks = 0;     ///< the table was full: short tracks that had ended made room for new ones
  std::uint32_t unadjusted_points = 0;  ///< did not fit into the bundle adjustment
  std::uint32_t shortened_tracks = 0;   ///< lost their oldest observation, its camera is too far back
  bool scale_held = false;              ///< fewer than two fixed cameras determine the scale: one distance was held
  double rms_px = 0;                    ///< after bundle adjustment, this window, per coordinate
  double scale_step =
      1;  ///< baseline that the pair alone gives the known points / baseline from resection: 1 is perfect
};

struct SequenceCamera {
  std::int64_t keyframe_id = 0;
  Pose pose;
  bool posed = false;
  bool final_pose = false;
  /// One sigma along the world's axes, relative to the strip's first camera and the length of its first baseline, which
  /// are the world's gauge (sequence_covariance.hpp). 0 if it is not known, and for the first camera.
  double sigma_position[3] = {0, 0, 0};
  /// Covariance of the step from the previous camera: StepCovariance of fsw/vision/stereo/depth/pose_error.hpp. Only of
  /// an accepted camera.
  double step_covariance[21] = {};
  /// Covariance of the pose in the same gauge, lower triangle row by row: rotation vector in the camera's axes (rad;
  /// the estimated attitude is exp(error) times the true one), then centre (world units). Only of an accepted camera;
  /// all 0 if it is not known, and for the first camera.
  double covariance[21] = {};
};

/// A point of the structure that no longer changes, with all its observations. The component turns ideal pixels into
/// real ones.
struct FinalObservation {
  std::int64_t keyframe_id = 0;
  float x = 0, y = 0;  ///< ideal px
};
struct FinalPoint {
  double position[3] = {0, 0, 0};
  float error_px = 0;  ///< root mean square distance between projection and observation
  FixedVector<FinalObservation, limits::max_track_length> observations;
};

enum class SequencePhase : std::uint8_t {
  idle,
  relate,
  rank,              ///< the new keyframe with one of the earlier ones that have no pose yet
  begin,             ///< the structure, with the best pair
  extend_from_pair,  ///< one more keyframe gets its pose from the points of the best pair
  decide,
  resect,
  triangulate,
  adjust,
  prune,
  readjust,
  conclude,
  // What the slice before has left in the workspace goes on (Sequence::keeps).
  relating,      ///< the pair
  state_errors,  ///< after adjust
  restate_errors
};

/// The whole state of a strip between steps. It is trivially copyable: its bytes are the checkpoint.
struct SequenceState {
  CameraModel camera;
  SequenceParams params;
  bool strip_open = false;
  SequencePhase phase = SequencePhase::idle;
  bool adjusting = false;  ///< `bundle` holds an adjustment whose errors are not stated yet
  // The strip. Ordinals count posed keyframes from 0; cameras[i] is ordinal oldest + i.
  std::uint32_t oldest = 0;
  std::uint32_t final_count = 0;   ///< ordinals below are final
  std::uint32_t taken_count = 0;   ///< ordinals below were handed out
  std::uint32_t point_cursor = 0;  ///< tracks below were searched for final points
  std::uint32_t back = 0;          ///< the keyframe at work is matched with the one so many before the newest
  FixedVector<SequenceCamera, limits::max_bundle_cameras> cameras;
  FirstPair first_pair;
  FixedVector<std::int64_t, max_first_keyframes> dropped;  ///< keyframes that the work on the newest one dropped
  StripCovariance covariance;
  Tracks tracks;
  Corners corners;  ///< of the newest posed keyframe, refined
  // The keyframe at work.
  std::int64_t keyframe_id = 0;
  std::uint64_t seed = 0;
  Corners new_corners;
  Matches matches;
  FixedVector<std::uint8_t, limits::max_matches> related;  ///< per match: agrees with the two-view estimate
  double pair_rotation[9] = {};                            ///< this from previous, row-major
  double pair_translation[3] = {};
  BundleProgress bundle;
  SequenceReport report;
};
static_assert(std::is_trivially_copyable_v<SequenceState>);

struct SequenceWorkspace;  // defined in sequence_workspace.hpp: a component owns one

/// Gives every matched corner of `corners_b` its refined position. The caller matches the *next* keyframe with the
/// resulting corners, so that positions chain along a track.
void refine_corners(const Matches& matches, Corners& corners_b);

/// Works on a state and a scratch that its owner keeps (both static, megabytes). Neither the object nor, unless keeps()
/// says so, the workspace carries anything from step to step, so that a copy of the state from any step continues with
/// the same result to the last bit.
class Sequence {
 public:
  Sequence(SequenceState& state, SequenceWorkspace& workspace) : s_(state), w_(workspace) {}

  /// Clears everything. `invalid_argument` for parameters out of range; the Status of validate() for the
  /// camera.
  Status begin_strip(const CameraModel& camera, const SequenceParams& params);

  /// Takes a copy of a keyframe's corners (real px) and of its matches to the newest posed keyframe (Match.a its
  /// corners, Match.b these; xb, yb the refined position). Final cameras and points must have been taken. `not_ready`
  /// while another keyframe is at work, `invalid_argument` for an index out of range, a corner
  /// matched twice, or a position that is not finite.
  Status begin_keyframe(std::int64_t keyframe_id, const Corners& corners, const Matches& matches_to_previous,
                        std::uint64_t seed) {
    return begin_keyframe_on(0, keyframe_id, corners, matches_to_previous, seed);
  }
  /// The same with matches to the keyframe `back` before the newest posed one: Match.a is one of corners_of(back). The
  /// newer ones may be bad images, or of other ground. For `back` > 0 the structure must have begun, and
  /// min_older_inliers known points must agree with the pose. `not_ready` also where can_go_back_to(back) is false.
  Status begin_keyframe_on(std::uint32_t back, std::int64_t keyframe_id, const Corners& corners, const Matches& matches,
                           std::uint64_t seed);
  [[nodiscard]] bool can_go_back_to(std::uint32_t back) const;
  /// Corners (real px) of the keyframe `back` before the newest posed one: those of its tracks.
  void corners_of(std::uint32_t back, Corners& corners) const;
  [[nodiscard]] std::size_t count_corners(std::uint32_t back) const;
  /// Does one bounded slice of work: a part of relating one pair, begin the structure, decide between the motions of
  /// the first pair, resect, triangulate, one iteration of an adjustment or a part of the errors of its result, prune
  /// or conclude. A keyframe that fails (see report().verdict) leaves the strip with its newest keyframe and tracks
  /// unchanged, so that it may be tried against another one. A keyframe with the verdict `waiting` belongs to the
  /// strip, and gets its pose when the structure begins.
  Status step();
  /// Runs begin_keyframe and all its steps.
  Status add_keyframe(std::int64_t keyframe_id, const Corners& corners, const Matches& matches_to_previous,
                      std::uint64_t seed, SequenceReport& report);
  /// Before the end of a strip whose structure has not begun: true if a pair can begin it now. The steps that follow do
  /// so; then idle() is true again.
  bool begin_with_best_pair();
  /// Ends the strip: every camera and every good point becomes final as it is. `not_ready` while a keyframe is at work.
  Status flush();

  /// Takes final cameras in order, each once; false when there is none (yet).
  bool take_final_camera(SequenceCamera& camera);
  /// One sigma, as a share, that the open lens gives to depths near `depth` between an accepted camera and the one
  /// before it; it is not in SequenceCamera::step_covariance.
  [[nodiscard]] double depth_error_of_lens(const SequenceCamera& camera, double depth) const;
  /// Takes final points, each once, only those with two or more observations; false when there is none (yet).
  bool take_final_point(FinalPoint& point);

  /// The newest posed keyframes, oldest first; those that are not final are provisional.
  [[nodiscard]] const FixedVector<SequenceCamera, limits::max_bundle_cameras>& cameras() const { return s_.cameras; }
  /// The report on the keyframe at work, or on the last one.
  [[nodiscard]] const SequenceReport& report() const { return s_.report; }
  [[nodiscard]] bool idle() const { return s_.phase == SequencePhase::idle; }
  /// The next step goes on with what this workspace holds.
  [[nodiscard]] bool keeps() const {
    return s_.phase == SequencePhase::relating || s_.phase == SequencePhase::state_errors ||
           s_.phase == SequencePhase::restate_errors;
  }
  /// Whether the keyframes of cameras() have poses: the structure has begun.
  [[nodiscard]] bool begun() const { return s_.first_pair.begun; }
  /// Whether a pair of the keyframes that wait can begin the structure.
  [[nodiscard]] bool can_begin() const { return !begun() && s_.first_pair.best.error > 0; }
  /// Keyframes that left the strip without a pose during the work on the last keyframe.
  [[nodiscard]] const FixedVector<std::int64_t, max_first_keyframes>& dropped() const { return s_.dropped; }

 private:
  Status conclude();
  /// Ordinal of the newest keyframe.
  [[nodiscard]] std::uint32_t newest() const { return s_.oldest + static_cast<std::uint32_t>(s_.cameras.size()) - 1; }

  SequenceState& s_;
  SequenceWorkspace& w_;
};

}  // namespace ilp
