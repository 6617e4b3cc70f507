// Structure and motion of one strip, keyframe by keyframe, with known intrinsics (paper 3.2; decisions.md, 4, 5, 7).
//
// Keyframe by keyframe: matches to the previous keyframe extend tracks; the first pair gives the frame and the scale; every
// later camera is resected from the tracks' points (P3P in RANSAC, then non-linear); new points are triangulated; a bundle
// adjustment refines the window's cameras and points while older cameras stay fixed. A camera is *final* when it leaves the
// window, and never changes again.
#pragma once

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/features/feature_types.hpp"
#include "fsw/vision/twoview/two_view.hpp"

namespace ilp {

struct SequenceParams {
  std::uint32_t window_keyframes = 5;     ///< paper 3.2.2; at most limits::max_window_keyframes
  RansacParams two_view;
  double resection_threshold_px = 2.0;
  std::uint32_t resection_max_trials = 300;
  std::uint32_t min_resection_inliers = 15;
  double max_reprojection_px = 2.0;       ///< observations above it are dropped from their track
  double min_triangulation_angle_rad = 0.01;
  std::uint32_t max_bundle_iterations = 20;
  double robust_px = 1.0;                 ///< Huber bound of the bundle adjustment
};

enum class SequenceVerdict : std::uint8_t {
  ok,
  waiting,              ///< first keyframe of a strip: nothing to relate yet
  too_few_matches,
  two_view_failed,      ///< see two_view.verdict
  resection_failed,
  implausible,          ///< scale step or attitude step beyond bounds
  count
};
[[nodiscard]] const char* sequence_verdict_name(SequenceVerdict verdict);

/// What happened to one keyframe.
struct SequenceReport {
  SequenceVerdict verdict = SequenceVerdict::waiting;
  TwoViewResult two_view;              ///< of the pair (previous, this)
  std::uint32_t matches = 0;
  std::uint32_t resection_inliers = 0;
  std::uint32_t points = 0;            ///< seen by this keyframe
  double rms_px = 0;                   ///< after bundle adjustment, this window
  double scale_step = 1;               ///< |t| of the pair re-estimated / expected from the structure: 1 is perfect
};

struct SequenceCamera {
  std::int64_t keyframe_id = 0;
  Pose pose;
  bool posed = false;
  bool final_pose = false;
  double sigma_position[3] = {0, 0, 0};  ///< one sigma, world axes, from the window's normal equations
};

/// A point of the structure that no longer changes, with all its observations (real pixels are the component's business:
/// these are corner indices).
struct FinalObservation {
  std::int64_t keyframe_id = 0;
  float x = 0, y = 0;  ///< ideal px
};
struct FinalPoint {
  double position[3] = {0, 0, 0};
  float error_px = 0;
  FixedVector<FinalObservation, limits::max_track_length> observations;
};

}  // namespace ilp
