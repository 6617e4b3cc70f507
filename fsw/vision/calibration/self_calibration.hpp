// Self-calibration from the keyframes of a strip whose camera is not known (paper 3.2.1; decisions.md, 6).
//
// Keyframe by keyframe, matches to the previous keyframe extend tracks, and the fundamental matrix and the homography
// of the pair get their GRIC. When the fundamental matrix is clearly the better model for all pairs of a set of
// consecutive keyframes, the set gets a projective reconstruction, its dual absolute quadric, and a metric
// reconstruction refined with the focal length free. A result requires that covariance, parts of the data and other
// starts of the search agree. Otherwise the report gives the reason, and the set slides on. After a pair without
// information the set starts over.
//
// The focal length shows in how the image bends when the camera tilts: the optical axes must differ. Translation and
// turns about the vertical alone leave it undetermined, whatever the ground.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/result.hpp"
#include "fsw/base/verdicts.hpp"
#include "fsw/vision/calibration/calibration_views.hpp"
#include "fsw/vision/calibration/focal_refinement.hpp"
#include "fsw/vision/calibration/plane_focal.hpp"
#include "fsw/vision/features/feature_types.hpp"
#include "fsw/vision/twoview/two_view.hpp"

namespace ilp {

struct CalibrationParams {
  /// Views of a set, 3 to limits::max_calibration_views. With fewer than `full_views`, answers are off by more than 1 %
  /// more often: their sigma must be smaller. A sixth view lets half as many flights again find their camera.
  std::uint32_t min_views = 4, full_views = 5, max_views = 6;
  RansacParams pair;           ///< F and H; its seed is mixed with that of the keyframe
  double min_gric_gain = 0.1;  ///< (GRIC(H) - GRIC(F)) / inliers for "clearly better": -1.4 on a plane, 2.6 at most
  double min_motion_px = 4;    ///< median displacement of matches
  double min_field_of_view_rad = 0.35;  ///< of the image's width: 20 degrees
  double max_field_of_view_rad = 2.1;   ///< 120 degrees
  double sigma_centre = 0.02;           ///< one sigma of the principal point about the nominal one / image width
  double noise_px = 0.3;  ///< expected error of a coordinate; sets the weight of the prior on the principal point
  double least_noise_px = 0.05;     ///< least noise that a stated sigma assumes, see judge_focal
  double max_noise_px = 1;          ///< beyond it the reconstruction is wrong
  double max_sigma = 0.006;         ///< of the focal length, relative
  double max_sigma_of_few = 0.004;  ///< with fewer than `full_views`
  double max_consistency = 3;       ///< see FocalJudgement
};

/// One pair of consecutive keyframes.
struct CalibrationPair {
  std::int64_t first_id = 0, second_id = 0;
  CalibrationVerdict verdict = CalibrationVerdict::collecting;  ///< ok: F is clearly better
  PairModel model = PairModel::none;
  std::uint32_t matches = 0, inliers = 0;
  double gric_f = 0, gric_h = 0;  ///< both over the inliers of F
  double motion_px = 0;           ///< median displacement
};

struct CalibrationReport {
  CalibrationVerdict verdict = CalibrationVerdict::collecting;
  CameraModel camera;         ///< when ok: the camera to freeze
  double sigma_focal_px = 0;  ///< one sigma of camera.fx, spread over parts of the data included
  double sigma_cx_px = 0, sigma_cy_px = 0;
  FixedVector<CalibrationPair, limits::max_calibration_views - 1> pairs;
  std::uint32_t views = 0, points = 0, observations = 0;
  double noise_px = 0;          ///< error of a coordinate, from the residuals
  double axes_spread_rad = 0;   ///< largest angle between two optical axes
  double consistency = 0;       ///< see FocalJudgement
  double start_focal_px = 0;    ///< of the absolute quadric; 0 if the search did not get there
  double refined_focal_px = 0;  ///< of the refinement, accepted or not
  double refined_sigma_px = 0;  ///< its covariance's
  PlanePair plane;              ///< of the newest pair
};

enum class CalibrationPhase : std::uint8_t {
  idle,
  relate,
  pair,
  resect,
  adjust_projective,
  upgrade,
  adjust_metric,
  readjust_metric,
  verify
};

/// The whole state between steps. It is trivially copyable: its bytes are the checkpoint.
struct CalibrationState {
  CameraModel nominal;
  CalibrationParams params;
  CalibrationPhase phase = CalibrationPhase::idle;
  // The set, oldest view first; bit v of the tracks' masks is view v.
  FixedVector<std::int64_t, limits::max_calibration_views> keyframes;
  FixedVector<CalibrationPair, limits::max_calibration_views - 1> pairs;
  CalibrationTracks tracks;
  Corners corners;  ///< of the newest view, refined, real px
  // The keyframe at work.
  std::int64_t keyframe_id = 0;
  std::uint64_t seed = 0;
  Corners new_corners;
  Matches matches;
  // The reconstruction at work.
  ViewSet posed = 0;
  std::uint32_t round = 0;
  std::uint32_t slice = 0;
  ProjectiveCameras projective;
  MetricViews metric;
  AdjustmentProgress progress;
  MetricCovariance covariance;
  Verification verification;
  CalibrationReport report;
};
static_assert(std::is_trivially_copyable_v<CalibrationState>);

struct CalibrationWorkspace;  // defined in calibration_workspace.hpp: a component owns one

/// Works on a state and a scratch that its owner keeps (both static). The workspace carries from step to step only the
/// part that a verification is at work on. With a cleared workspace that part starts over, so that a copy of the state
/// from any step continues with the same result to the last bit.
class SelfCalibration {
 public:
  SelfCalibration(CalibrationState& state, CalibrationWorkspace& workspace) : s_(state), w_(workspace) {}

  /// Starts over. `nominal` gives the image size, the point about which the principal point is expected, the pixels'
  /// aspect and the distortion. Its focal length is not used as an estimate: it is only the unit of the distortion.
  /// `invalid_argument` for parameters out of range; the Status of validate() for the camera.
  Status begin(const CameraModel& nominal, const CalibrationParams& params);

  /// Ends the set. The next keyframe is the first of another set (a new strip).
  void begin_set();

  /// Takes a copy of a keyframe's corners (real px) and of its matches to the keyframe before (Match.a its corners,
  /// Match.b these; xb, yb the refined position), as Sequence::begin_keyframe does; the first keyframe of a set has no
  /// matches. `not_ready` while another keyframe is at work, `invalid_argument` (match, corner)
  /// for an index out of range, a corner matched twice, or a position that is not finite.
  Status begin_keyframe(std::int64_t keyframe_id, const Corners& corners, const Matches& matches_to_previous,
                        std::uint64_t seed);
  /// Does one bounded slice of work: relate a pair, resect a view, one iteration of an adjustment.
  Result<bool> step();
  /// Runs begin_keyframe and all its steps.
  Status add_keyframe(std::int64_t keyframe_id, const Corners& corners, const Matches& matches_to_previous,
                      std::uint64_t seed, CalibrationReport& report);

  /// Corners of the newest keyframe with the refined positions. Match the next keyframe with these.
  [[nodiscard]] const Corners& corners() const { return s_.corners; }
  /// The report on the newest keyframe, once all its steps are done.
  [[nodiscard]] const CalibrationReport& report() const { return s_.report; }
  [[nodiscard]] bool idle() const { return s_.phase == CalibrationPhase::idle; }

 private:
  Status relate();
  Status reconstruct();
  void resect();
  void adjust_projectively();
  void upgrade();
  void adjust_metrically(bool last);
  void verify();
  void conclude();

  void end(CalibrationVerdict verdict);
  void restart_with_new();
  void slide();
  void extend_tracks();
  [[nodiscard]] RefinementSetup setup() const;
  [[nodiscard]] double max_sigma() const;

  CalibrationState& s_;
  CalibrationWorkspace& w_;
};

}  // namespace ilp
