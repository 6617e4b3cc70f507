// Structure and motion of one strip, keyframe by keyframe, with known intrinsics (paper 3.2; decisions.md, 4, 5, 7).
//
// For every keyframe, matches to the previous keyframe, or to a slightly older one, extend tracks. A pair of the first
// five keyframes begins the structure. Every other camera is resected from the points of the tracks (P3P in RANSAC,
// then non-linear refinement), and new points are triangulated. A bundle adjustment then refines the cameras and points
// of the window; older cameras stay fixed. A camera becomes *final* when it leaves the window, and never changes
// afterwards; a point becomes final when only final cameras see it.
//
// World frame: unless the caller knows its attitude, the first camera is at the origin and looks straight down the z
// axis; its x axis is world x, its y axis is world -y. If the caller knows the height above the ground, it sets the
// scale. Otherwise the unit of length is the distance from the first camera to the second one, or to the first one with
// a sufficient baseline (FirstPair::scale_camera).
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
  std::uint32_t window_keyframes = 5;   ///< paper 3.2.2; 2 to limits::max_window_keyframes
  RansacParams two_view;                ///< its seed is combined with that of the keyframe
  double resection_threshold_px = 1.0;  ///< inlier threshold of the resection
  /// The errors of matches have heavy tails, in real and in rendered images: no threshold separates errors of several
  /// sigma from good matches. Cauchy's loss gives such errors little weight, Huber's does not.
  double robust_px = 0.5;  ///< scale of the Cauchy loss, and bound of the Huber loss in the resection
  /// Factor on the position errors that follow from the scatter of the matches. Registration errors that all matches of
  /// an image share leave no residual. On rendered relief under a low sun they are 0.02 to 0.04 px and smooth over the
  /// image; on a rendered plane they are zero. One factor for all axes and lengths is a bound, not a model. Over 60
  /// straight keyframes (sim/campaigns/straight.ini) errors along the track need a factor of 1.7, in height 2 to 2.7,
  /// across the track 4 to 5.5, and in total 3; over a plane 1 is enough.
  double error_factor = 3;
  /// Covariance of the intrinsics, lower triangle row by row in the order of Intrinsic; 0 for a camera that is known
  /// exactly. Estimated pose errors include its effect.
  std::array<double, intrinsic_count*(intrinsic_count + 1) / 2> lens_covariance{};
  /// The structure begins when the expected relative depth error of a pair (expected_depth_error) is at most this
  /// value. If no pair reaches it, the best pair begins when max_first_keyframes keyframes have come, or at the end of
  /// the strip.
  double max_first_depth_error = 0.2;
  double first_height =
      0;  ///< > 0: median depth of the first pair's points, which sets the scale; 0: its baseline has length 1
  /// Attitude of the first camera, unit quaternion w, x, y, z. By default the camera looks straight down and its x axis
  /// is world x.
  double q_first[4] = {0, 1, 0, 0};
  double max_tilt_step_rad = 0.7;  ///< largest angle between the optical axes of consecutive keyframes
  /// Largest plausible step: (baseline - the part that a turn around the viewed ground explains) divided by the extent
  /// of an image on the ground.
  double max_step_footprints = 1.5;
};

/// Two-view estimate of this keyframe and the previous one: the fields of TwoViewResult without the pose.
struct PairReport {
  TwoViewVerdict verdict = TwoViewVerdict::too_few_inliers;
  std::uint32_t inliers = 0;
  double gric_e = 0, gric_h = 0;  ///< GRIC of the epipolar geometry and of the homography
  double median_parallax_px = 0;
  double rms_px = 0;
  double sigma_rotation_rad = 0;
  double sigma_direction_rad = 0;
};

/// Report on the processing of one keyframe.
struct SequenceReport {
  SequenceVerdict verdict = SequenceVerdict::waiting;
  PairReport two_view;
  std::uint32_t matches = 0;
  std::uint32_t known_points = 0;  ///< matches with known points of the structure, which the resection uses
  std::uint32_t resection_inliers = 0;
  std::uint32_t points = 0;                ///< points that this keyframe sees
  std::uint32_t new_points = 0;            ///< points triangulated at this keyframe
  std::uint32_t dropped_observations = 0;  ///< observations dropped as outliers after the bundle adjustment
  std::uint32_t lost_points = 0;           ///< points left with fewer than two observations
  std::uint32_t bundle_points = 0;
  std::uint32_t bundle_observations = 0;
  std::uint32_t bundle_iterations = 0;
  std::uint32_t refused_tracks = 0;  ///< new tracks that were not begun because the table was full
  std::uint32_t evicted_tracks = 0;  ///< ended short tracks that were removed for new ones because the table was full
  std::uint32_t unadjusted_points = 0;  ///< points that exceeded the capacity of the bundle adjustment
  /// Tracks that lost their oldest observation because its camera left the strip's state.
  std::uint32_t shortened_tracks = 0;
  bool scale_held = false;  ///< one distance was held, because fewer than two fixed cameras determine the scale
  double rms_px = 0;        ///< RMS residual of the window after the bundle adjustment, per coordinate
  double scale_step =
      1;  ///< baseline from the pair alone and known points, divided by the baseline from resection; 1: they agree
};

struct SequenceCamera {
  std::int64_t keyframe_id = 0;
  Pose pose;
  bool posed = false;       ///< `pose` is known
  bool final_pose = false;  ///< `pose` never changes again
  /// One-sigma position error along the world's axes. The gauge is the world frame: the strip's first camera and the
  /// length of its first baseline are without error (sequence_covariance.hpp). 0 if it is not known, and for the first
  /// camera.
  double sigma_position[3] = {0, 0, 0};
  /// Covariance of the step from the previous camera, as StepCovariance of fsw/vision/stereo/depth/pose_error.hpp. Only
  /// valid in a camera from take_final_camera.
  double step_covariance[21] = {};
  /// Covariance of the pose in the same gauge, lower triangle row by row: rotation vector in the camera's axes (rad;
  /// the estimated attitude is exp(error) times the true one), then centre (world units). Only valid in a camera from
  /// take_final_camera. All 0 if it is not known, and for the first camera.
  double covariance[21] = {};
};

/// A point of the structure that no longer changes, with all its observations. The caller converts ideal pixels to real
/// ones.
struct FinalObservation {
  std::int64_t keyframe_id = 0;
  float x = 0, y = 0;  ///< ideal px
};
struct FinalPoint {
  double position[3] = {0, 0, 0};  ///< world
  float error_px = 0;              ///< RMS distance between projections and observations
  FixedVector<FinalObservation, limits::max_track_length> observations;
};

enum class SequencePhase : std::uint8_t {
  idle,
  relate,
  rank,              ///< ranks the pair of the new keyframe and one of the earlier ones without a pose
  begin,             ///< begins the structure with the best pair
  extend_from_pair,  ///< one more keyframe gets its pose from the points of the best pair
  decide,
  resect,
  triangulate,
  adjust,
  prune,
  readjust,
  conclude,
  // These phases continue with what the previous slice left in the workspace (Sequence::keeps).
  relating,      ///< continues the two-view estimate
  state_errors,  ///< computes the errors after adjust
  restate_errors
};

/// The complete state of a strip between steps. It is trivially copyable: its bytes are the checkpoint.
struct SequenceState {
  CameraModel camera;
  SequenceParams params;
  bool strip_open = false;
  SequencePhase phase = SequencePhase::idle;
  bool adjusting = false;  ///< `bundle` holds an unfinished adjustment
  // The strip. Ordinals count posed keyframes from 0; cameras[i] has ordinal oldest + i.
  std::uint32_t oldest = 0;
  std::uint32_t final_count = 0;   ///< cameras with ordinals below this one are final
  std::uint32_t taken_count = 0;   ///< cameras with ordinals below this one were taken by take_final_camera
  std::uint32_t point_cursor = 0;  ///< tracks with indices below this one were searched for final points
  std::uint32_t back = 0;  ///< the current keyframe is matched with the keyframe this many before the newest one
  FixedVector<SequenceCamera, limits::max_bundle_cameras> cameras;
  FirstPair first_pair;
  /// Keyframes that were dropped while the newest one was processed.
  FixedVector<std::int64_t, max_first_keyframes> dropped;
  StripCovariance covariance;
  Tracks tracks;
  Corners corners;  ///< corners of the newest posed keyframe, with refined positions
  // The current keyframe.
  std::int64_t keyframe_id = 0;
  std::uint64_t seed = 0;
  Corners new_corners;
  Matches matches;
  /// Per match: nonzero if it agrees with the two-view estimate.
  FixedVector<std::uint8_t, limits::max_matches> related;
  double pair_rotation[9] = {};  ///< rotation from the previous camera to this one, row-major
  double pair_translation[3] = {};
  BundleProgress bundle;
  SequenceReport report;
};
static_assert(std::is_trivially_copyable_v<SequenceState>);

struct SequenceWorkspace;  // defined in sequence_workspace.hpp: a component owns one

/// Moves every matched corner of `corners_b` to its refined position. The caller matches the *next* keyframe with the
/// resulting corners, so that each match of a track starts at the refined position of the last one.
void refine_corners(const Matches& matches, Corners& corners_b);

/// Processes a strip on a state and a workspace that its owner keeps (both static, megabytes). The object carries
/// nothing from step to step, and the workspace only if keeps() returns true. A copy of the state taken while keeps()
/// is false therefore continues with a bit-identical result.
class Sequence {
 public:
  Sequence(SequenceState& state, SequenceWorkspace& workspace) : s_(state), w_(workspace) {}

  /// Clears the state and begins a strip. Returns `invalid_argument` if a parameter is out of range, or the Status of
  /// validate() for the camera.
  Status begin_strip(const CameraModel& camera, const SequenceParams& params);

  /// Begins a keyframe: copies its corners (real px) and its matches to the newest posed keyframe. Match::a is a corner
  /// of the posed keyframe, Match::b one of `corners`, and xb, yb its refined position. Final cameras and points must
  /// have been taken before. Returns `not_ready` while another keyframe is processed, `invalid_argument` if an index is
  /// out of range, a corner is matched twice, or a position is not finite.
  Status begin_keyframe(std::int64_t keyframe_id, const Corners& corners, const Matches& matches_to_previous,
                        std::uint64_t seed) {
    return begin_keyframe_on(0, keyframe_id, corners, matches_to_previous, seed);
  }
  /// Does the same with matches to the keyframe `back` before the newest posed one; Match::a is one of
  /// corners_of(back). Use it if the newer keyframes are bad images or show other ground. For `back` > 0 the structure
  /// must have begun, and min_older_inliers known points must agree with the pose. Also returns `not_ready` if
  /// can_go_back_to(back) is false.
  Status begin_keyframe_on(std::uint32_t back, std::int64_t keyframe_id, const Corners& corners, const Matches& matches,
                           std::uint64_t seed);
  [[nodiscard]] bool can_go_back_to(std::uint32_t back) const;
  /// The corners (real px) of the keyframe `back` before the newest posed one: those that belong to tracks.
  void corners_of(std::uint32_t back, Corners& corners) const;
  [[nodiscard]] std::size_t count_corners(std::uint32_t back) const;
  /// Does one bounded slice of work: a part of relating one pair, beginning the structure, deciding between the motions
  /// of the first pair, resection, triangulation, one iteration of an adjustment or a part of its errors, pruning, or
  /// the conclusion. If a keyframe fails (report().verdict), the newest keyframe and the tracks of the strip are
  /// unchanged, so the keyframe may be tried against another one. A keyframe with the verdict `waiting` belongs to the
  /// strip and gets its pose when the structure begins.
  Status step();
  /// Runs begin_keyframe and all its steps.
  Status add_keyframe(std::int64_t keyframe_id, const Corners& corners, const Matches& matches_to_previous,
                      std::uint64_t seed, SequenceReport& report);
  /// Begins the structure with the best pair at the end of a strip whose structure has not begun. Returns false if no
  /// pair can begin it. After true, call step() until idle() is true again.
  bool begin_with_best_pair();
  /// Ends the strip: every camera and every good point becomes final. Returns `not_ready` while a keyframe is
  /// processed.
  Status flush();

  /// Takes the next final camera, in order, each once. Returns false if there is none (yet).
  bool take_final_camera(SequenceCamera& camera);
  /// Returns the relative one-sigma error that the uncertainty of the intrinsics causes in depths near `depth` (world
  /// units) between a final camera and the one before it. SequenceCamera::step_covariance does not include it.
  [[nodiscard]] double depth_error_of_lens(const SequenceCamera& camera, double depth) const;
  /// Takes the next final point, each once; points with fewer than two observations are left out. Returns false if
  /// there is none (yet).
  bool take_final_point(FinalPoint& point);

  /// The newest keyframes of the strip, oldest first. Poses that are not final are provisional.
  [[nodiscard]] const FixedVector<SequenceCamera, limits::max_bundle_cameras>& cameras() const { return s_.cameras; }
  /// The report on the current keyframe, or on the last one.
  [[nodiscard]] const SequenceReport& report() const { return s_.report; }
  [[nodiscard]] bool idle() const { return s_.phase == SequencePhase::idle; }
  /// Returns true if the next step continues with the content of the workspace.
  [[nodiscard]] bool keeps() const {
    return s_.phase == SequencePhase::relating || s_.phase == SequencePhase::state_errors ||
           s_.phase == SequencePhase::restate_errors;
  }
  /// Returns true if the structure has begun: the keyframes of cameras() have poses.
  [[nodiscard]] bool begun() const { return s_.first_pair.begun; }
  /// Returns true if a pair of the waiting keyframes can begin the structure.
  [[nodiscard]] bool can_begin() const { return !begun() && s_.first_pair.best.error > 0; }
  /// Keyframes that left the strip without a pose while the last keyframe was processed.
  [[nodiscard]] const FixedVector<std::int64_t, max_first_keyframes>& dropped() const { return s_.dropped; }

 private:
  Status conclude();
  /// Ordinal of the newest keyframe.
  [[nodiscard]] std::uint32_t newest() const { return s_.oldest + static_cast<std::uint32_t>(s_.cameras.size()) - 1; }

  SequenceState& s_;
  SequenceWorkspace& w_;
};

}  // namespace ilp
