// Compares images with given intrinsics, and builds intrinsics in the form that the flight freezes.
#pragma once

#include "fsw/base/geometry.hpp"
#include "fsw/base/status.hpp"
#include "fsw/base/verdicts.hpp"
#include "fsw/vision/calibration/calibration_views.hpp"
#include "fsw/vision/calibration/focal_refinement.hpp"
#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"

namespace ilp {

/// The nominal camera with the focal length and the principal point of `views`. The distortion is converted to the new
/// unit. It bends the same pixels, except that its centre moves with the principal point: if that is many pixels and
/// the distortion strong, calibrate again with this camera as the nominal one.
[[nodiscard]] CameraModel calibrated_camera(const CameraModel& nominal, const MetricViews& views);

struct CalibrationCheckParams {
  double sigma_centre = 0.02;    ///< one sigma of the principal point / image width
  double noise_px = 0.3;         ///< expected error of a coordinate
  double least_noise_px = 0.05;  ///< least noise that a stated sigma assumes, see judge_focal
  double max_sigma = 0.015;      ///< of the focal length, relative: beyond it the check cannot tell
  double significance = 4;       ///< a deviation of more sigmas contradicts; errors of up to 6 % may be missed
  double max_deviation = 0.015;  ///< of the given focal length, relative: a smaller one is always tolerated
  double max_consistency = 3;    ///< see FocalJudgement
};

struct CalibrationCheck {
  CalibrationCheckVerdict verdict = CalibrationCheckVerdict::cannot_tell;
  double focal_px = 0, sigma_px = 0;  ///< as the images have it; sigma 0: they do not tell
  double deviation = 0;               ///< (given - focal_px) / focal_px
  double noise_px = 0;
  double consistency = 0;
  std::uint32_t views = 0, points = 0;
};

struct CalibrationWorkspace;  // defined in calibration_workspace.hpp

/// Frees the focal length in a window of posed cameras after its adjustment (all of the same camera, `given`): the
/// newest limits::max_calibration_views of them and the points that they see. The window is not changed. A steep,
/// swinging flight over relief determines the focal length; over flat ground, or in level flight, the verdict is
/// `cannot_tell`, without an adjustment where images with the least noise could not tell either.
///
/// The object and its workspace take megabytes. The workspace must not be used otherwise from begin to the last step.
class CalibrationChecker {
 public:
  explicit CalibrationChecker(CalibrationWorkspace& workspace) : w_(workspace) {}

  /// `invalid_argument` for a camera or an observation that is out of range.
  Status begin(const CameraModel& given, const BundleProblem& window, const CalibrationCheckParams& params);
  /// Does one slice: an iteration of the adjustment, one part left out, or ten iterations of a search with a sample.
  void step(bool& pending);
  /// Call it after the last step.
  [[nodiscard]] const CalibrationCheck& result() const { return check_; }

 private:
  enum class Phase : std::uint8_t { idle, look, adjust, prune, readjust, covariance, verify };

  void look();
  void adjust(double robust, Phase next);
  void prune();
  void state_covariance();
  void verify();
  void judge();

  CalibrationWorkspace& w_;
  CameraModel given_;
  CalibrationCheckParams params_;
  Phase phase_ = Phase::idle;
  MetricViews views_;
  RefinementSetup setup_;
  AdjustmentProgress progress_;
  MetricCovariance covariance_;
  Verification verification_{};
  std::size_t slice_ = 0;
  bool all_tracks_ = false;  ///< the other starts search with all tracks, not with a sample
  CalibrationCheck check_;
};

/// Runs begin and all its steps.
Status check_calibration(const CameraModel& given, const BundleProblem& window, const CalibrationCheckParams& params,
                         CalibrationWorkspace& workspace, CalibrationCheck& check);

}  // namespace ilp
