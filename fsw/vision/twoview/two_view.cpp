#include "fsw/vision/twoview/two_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/twoview/plane_solutions.hpp"
#include "fsw/vision/twoview/refine/epipolar_refinement.hpp"
#include "fsw/vision/twoview/refine/forward_motion.hpp"
#include "fsw/vision/twoview/refine/match_error.hpp"
#include "fsw/vision/twoview/refine/narrow_motion.hpp"
#include "fsw/vision/twoview/robust/chance_matches.hpp"
#include "fsw/vision/twoview/robust/essential_problem.hpp"
#include "fsw/vision/twoview/robust/gric.hpp"
#include "fsw/vision/twoview/robust/homography_problem.hpp"
#include "fsw/vision/twoview/robust/model_score.hpp"
#include "fsw/vision/twoview/robust/robust_models.hpp"
#include "fsw/vision/twoview/robust/two_view_workspace.hpp"
#include "fsw/vision/twoview/solvers/decompose_essential.hpp"
#include "fsw/vision/twoview/solvers/homography.hpp"
#include "fsw/vision/twoview/solvers/singular_values.hpp"

namespace ilp {
namespace {

// Tukey's biweight at this bound keeps 95 % of the efficiency of least squares: 4.685 sigma, the threshold being 2
// sigma.
constexpr double inlier_bound = 2.34;

// Trials of five matches: they take about 10 ms on a processor of 1000 MIPS.
constexpr std::uint32_t trials_of_a_slice = 32;

// Of a motion against the one that turns the other way. Independent errors give the wrong one odds of 5 at most
// (test_narrow_motion.cpp). An error of 0.04 px that all of 1000 matches share (SequenceParams::error_factor) may give
// it odds of 20 where their own errors are 0.2 px.
constexpr double min_log_odds_of_turn = 25;

// Median without the rotation: with less, the baseline is unknown.
constexpr double least_parallax_px = 1.5;

/// Refines on all matches near the pose and scores the result. True when its score is better than `best`.
bool refine_and_compare(const NormalisedPairs& pairs, const RansacParams& params, PairIndices& selected,
                        RigidTransform& pose, RansacScore& best) {
  const double bound_px = inlier_bound * params.threshold_px;
  select_inliers(pairs, pose, bound_px, selected);
  refine_relative_pose(pairs, {selected.data(), selected.size()}, {RobustLoss::tukey, bound_px, 20, 1e-8}, pose);
  RansacScore score;
  if (!score_pose(pairs, pose, params.threshold_px, {best.cost}, score)) return false;
  best = score;
  return true;
}

/// A plane has two poses (decisions.md, 7): tries those of the homography against the pose found, by cost with
/// cheirality.
void try_planar_poses(const NormalisedPairs& pairs, const Mat3& homography, const RansacParams& params,
                      PairIndices& selected, RigidTransform& pose, RansacScore& best) {
  PlaneMotion candidates[4];
  const std::size_t count = decompose_homography(homography, candidates);
  for (std::size_t i = 0; i < count; ++i) {
    RigidTransform& candidate = candidates[i].b_from_a;
    RansacScore score;
    // A start with the homography's noise must not be refused for its cost.
    if (!score_pose(pairs, candidate, 2 * params.threshold_px, {4 * best.cost}, score)) continue;
    if (refine_and_compare(pairs, params, selected, candidate, best)) pose = candidate;
  }
}

double essential_gric(const NormalisedPairs& pairs, const RigidTransform& pose, double sigma_px) {
  const Mat3 essential = essential_from_pose(pose);
  Gric gric(gric_essential, sigma_px);
  for (const NormalisedPair& pair : pairs.exact) gric.add(sampson_squared(essential, pair, pairs.scale));
  return gric.value();
}

/// Rotation that brings the rays of a nearest to those of b (K. Arun, T. Huang, S. Blostein 1987), reweighted once so
/// that matches with parallax or errors have little influence.
Mat3 fit_rotation(const NormalisedPairs& pairs, double threshold_px, const Mat3& start) {
  Mat3 rotation = start;
  for (int round = 0; round < 4; ++round) {
    Mat3 correlation = Mat3::Zero();
    for (const NormalisedPair& pair : pairs.exact) {
      const double squared = homography_sampson_squared(rotation, pair, pairs.scale);
      const double bound2 = threshold_px * threshold_px;
      const double weight = round == 0 ? 1 : bound2 / (bound2 + squared);
      if (!(weight > 0)) continue;
      correlation += weight * pair.ray_b().normalized() * pair.ray_a().normalized().transpose();
    }
    SingularValues svd;
    if (!singular_values(correlation, svd)) break;
    rotation = svd.u * svd.v.transpose();
  }
  return rotation;
}

double rotation_gric(const NormalisedPairs& pairs, const Mat3& rotation, double sigma_px) {
  Gric gric(gric_rotation, sigma_px);
  for (const NormalisedPair& pair : pairs.exact) gric.add(homography_sampson_squared(rotation, pair, pairs.scale));
  return gric.value();
}

double median_parallax(const NormalisedPairs& pairs, const Mat3& rotation,
                       FixedVector<double, limits::max_matches>& scratch) {
  scratch.clear();
  for (const NormalisedPair& pair : pairs.exact) {
    static_cast<void>(scratch.push_back(std::sqrt(transfer_squared(rotation, pair, pairs.scale))));
  }
  return median_of(scratch);
}

/// One sigma of the matches' Sampson errors. The inliers alone would understate it, because they lack the errors beyond
/// the threshold. It is therefore the larger of their rms and of the estimate from the median of all matches near the
/// pose.
double noise_of(const NormalisedPairs& pairs, const RigidTransform& pose, double rms_px, double threshold_px,
                PairIndices& selected, FixedVector<double, limits::max_matches>& scratch) {
  const Mat3 essential = essential_from_pose(pose);
  select_inliers(pairs, pose, inlier_bound * threshold_px, selected);
  scratch.clear();
  for (const std::uint16_t i : selected) {
    static_cast<void>(scratch.push_back(std::sqrt(sampson_squared(essential, pairs.exact[i], pairs.scale))));
  }
  constexpr double sigma_from_median = 1.4826;  // of the absolute value of a Gaussian
  // The pose took five of the residuals' degrees of freedom.
  const auto count = static_cast<double>(selected.size());
  return std::fmax(rms_px, sigma_from_median * median_of(scratch)) * std::sqrt(count / std::fmax(1, count - 5));
}

/// Standard deviation of the points of image a or b across the line that they are nearest to, px.
double spread_across_line(const NormalisedPairs& pairs, bool in_b) {
  Vec2 mean = Vec2::Zero();
  double xx = 0;
  double xy = 0;
  double yy = 0;
  const auto count = static_cast<double>(pairs.size());
  for (const NormalisedPair& p : pairs.exact) mean += in_b ? Vec2(p.xb, p.yb) : Vec2(p.xa, p.ya);
  mean /= count;
  for (const NormalisedPair& p : pairs.exact) {
    const Vec2 d = (in_b ? Vec2(p.xb, p.yb) : Vec2(p.xa, p.ya)) - mean;
    xx += d.x() * d.x();
    xy += d.x() * d.y();
    yy += d.y() * d.y();
  }
  const double half_difference = 0.5 * (xx - yy);
  const double smaller = 0.5 * (xx + yy) - std::sqrt(half_difference * half_difference + xy * xy);
  return std::sqrt(std::fmax(0.0, smaller) / count) * (in_b ? pairs.scale.bx : pairs.scale.ax);
}

/// Matches without an essential matrix may still be explained by a rotation, such as identical images, which fit every
/// baseline.
void explain_by_rotation(const RansacParams& params, TwoViewWorkspace& workspace, InlierMask& inliers,
                         TwoViewResult& result) {
  const NormalisedPairs& all = workspace.pairs;
  Mat3 homography;
  PairIndices& selected = workspace.selected;
  if (!end_homography(all, params, selected, workspace.progress.planes, homography)) return;
  select_homography_inliers(all, homography, params.threshold_px, selected);
  select_subset(all, selected, workspace.subset);
  const Mat3 rotation = fit_rotation(workspace.subset, params.threshold_px, Mat3::Identity());
  const double sum = select_homography_inliers(all, rotation, params.threshold_px, selected);
  if (selected.size() < params.min_inliers || selected.empty()) return;
  for (const std::uint16_t i : selected) inliers[all.source[i]] = 1;
  result.verdict = TwoViewVerdict::too_little_parallax;
  result.b_from_a.rotation = rotation;
  result.inliers = static_cast<std::uint32_t>(selected.size());
  result.rms_px = std::sqrt(sum / static_cast<double>(selected.size()));
  result.median_parallax_px = median_parallax(workspace.subset, rotation, workspace.scratch);
  result.sigma_direction_rad = std::numeric_limits<double>::infinity();
}

/// The verdict on the pair; `workspace.subset` holds the inliers.
TwoViewVerdict judge(const NormalisedPairs& inliers, const TwoViewResult& result, const RansacParams& params) {
  const Mat3 rotation = fit_rotation(inliers, params.threshold_px, result.b_from_a.rotation);
  const double gric_r = rotation_gric(inliers, rotation, sigma_of(params));
  if (result.median_parallax_px < least_parallax_px || (gric_r <= result.gric_e && gric_r <= result.gric_h)) {
    return TwoViewVerdict::too_little_parallax;
  }
  // Points on a line fit any pose to within their noise, which then looks like information.
  const double min_spread_px = 4 * params.threshold_px;
  if (spread_across_line(inliers, false) < min_spread_px || spread_across_line(inliers, true) < min_spread_px ||
      !(result.sigma_direction_rad <= largest_sigma_direction_rad)) {
    return TwoViewVerdict::ill_conditioned;
  }
  return result.gric_h < result.gric_e ? TwoViewVerdict::planar : TwoViewVerdict::ok;
}

/// The model of all matches near the pose: what a plane is looked for in.
void gather_support(const RansacParams& params, TwoViewWorkspace& workspace) {
  TwoViewProgress& now = workspace.progress;
  const NormalisedPairs& all = workspace.pairs;
  now.pose = now.poses.best;
  now.best = {};
  now.best.cost = std::numeric_limits<double>::max();
  refine_and_compare(all, params, workspace.selected, now.pose, now.best);
  select_inliers(all, now.pose, inlier_bound * params.threshold_px, workspace.selected);
  select_subset(all, workspace.selected, workspace.subset);
  now.homography = Mat3::Identity();
  begin_homography(workspace.subset, params, workspace.subset_selected, now.planes);
}

/// Tries the poses that the plane has.
void compare_with_plane(const CameraModel& camera_b, const RansacParams& params, TwoViewWorkspace& workspace) {
  TwoViewProgress& now = workspace.progress;
  if (!now.plane_found) return;
  NormalisedPairs& all = workspace.pairs;
  PairIndices& selected = workspace.selected;
  const double side_px = std::min(camera_b.width, camera_b.height);
  if (remove_chance_matches(all, workspace.subset, now.homography, params.threshold_px,
                            inlier_bound * params.threshold_px, side_px, workspace.scratch,
                            workspace.subset_selected)) {
    select_subset(all, workspace.subset_selected, workspace.subset);
    all = workspace.subset;
    now.best.cost = std::numeric_limits<double>::max();
    refine_and_compare(all, params, selected, now.pose, now.best);
  }
  try_planar_poses(all, now.homography, params, selected, now.pose, now.best);
}

/// The terms of a narrow field; false where the field is wide. `workspace.selected` has the matches near the pose.
bool is_narrow(const RansacParams& params, TwoViewWorkspace& workspace, NarrowMotion& motion) {
  PairIndices& selected = workspace.selected;
  select_inliers(workspace.pairs, workspace.progress.pose, inlier_bound * params.threshold_px, selected);
  return narrow_motion(workspace.pairs, {selected.data(), selected.size()}, workspace.progress.pose, motion);
}

/// Refines the pose in the terms of a narrow field, and the motion that turns the other way. The better one of the two
/// is the pose.
void compare_turns(const RansacParams& params, TwoViewWorkspace& workspace) {
  TwoViewProgress& now = workspace.progress;
  NarrowMotion motion;
  if (!is_narrow(params, workspace, motion)) return;
  const PairSelection near{workspace.selected.data(), workspace.selected.size()};
  const RefinementParams refinement{RobustLoss::tukey, inlier_bound * params.threshold_px, 12, 1e-6};
  const auto refine = [&](NarrowMotion start) {
    refine_narrow_motion(workspace.pairs, near, refinement, start);
    return pose_of(start);
  };
  const auto cost = [&](const RigidTransform& pose) { return epipolar_cost(workspace.pairs, near, refinement, pose); };
  const RigidTransform refined = refine(motion);
  if (cost(refined) < cost(now.pose)) now.pose = refined;
  motion.turn_rad = -motion.turn_rad;
  const RigidTransform rival = refine(motion);
  now.rival_excess_px2 = std::fabs(cost(rival) - cost(now.pose));
  if (cost(rival) < cost(now.pose)) now.pose = rival;
}

/// Errors and verdict of the pose.
void describe_pose(const CameraModel& camera_a, const CameraModel& camera_b, const RansacParams& params,
                   TwoViewWorkspace& workspace, InlierMask& inliers, TwoViewResult& result) {
  const NormalisedPairs& all = workspace.pairs;
  PairIndices& selected = workspace.selected;
  RigidTransform& pose = workspace.progress.pose;
  double sum = select_inliers(all, pose, params.threshold_px, selected);
  MotionSpread spread;
  if (selected.size() > params.min_inliers && epipole_in_view(pose, camera_a, camera_b)) {
    const double rms_px = std::sqrt(sum / static_cast<double>(selected.size()));
    const double noise_px =
        noise_of(all, pose, rms_px, params.threshold_px, workspace.subset_selected, workspace.scratch);
    spread = average_over_minima(all, inlier_bound * params.threshold_px, noise_px, selected, pose);
    sum = select_inliers(all, pose, params.threshold_px, selected);
  }
  const NormalisedPairs& supported = workspace.subset;
  select_subset(all, selected, workspace.subset);
  for (const std::uint16_t i : selected) inliers[all.source[i]] = 1;
  result.b_from_a = pose;
  result.inliers = static_cast<std::uint32_t>(selected.size());
  if (selected.size() < params.min_inliers || selected.size() <= EssentialProblem::sample_size) return;

  result.rms_px = std::sqrt(sum / static_cast<double>(selected.size()));
  result.gric_e = essential_gric(supported, pose, sigma_of(params));
  result.gric_h = homography_gric(supported, workspace.progress.homography, sigma_of(params));
  result.median_parallax_px = median_parallax(supported, pose.rotation, workspace.scratch);
  const double noise_px =
      noise_of(all, pose, result.rms_px, params.threshold_px, workspace.subset_selected, workspace.scratch);
  pose_uncertainty(all, {selected.data(), selected.size()}, pose, noise_px, result.sigma_rotation_rad,
                   result.sigma_direction_rad);
  result.sigma_rotation_rad =
      std::sqrt(result.sigma_rotation_rad * result.sigma_rotation_rad + spread.rotation_rad * spread.rotation_rad);
  result.sigma_direction_rad =
      std::sqrt(result.sigma_direction_rad * result.sigma_direction_rad + spread.direction_rad * spread.direction_rad);
  result.verdict = judge(supported, result, params);
  if (result.verdict == TwoViewVerdict::planar) {
    find_plane_solutions(supported, workspace.progress.homography, pose, params.threshold_px, result.planes);
  }
  // A third view tells the two solutions of a plane apart.
  const bool open_to_rival =
      result.verdict == TwoViewVerdict::ok || (result.verdict == TwoViewVerdict::planar && result.planes.count < 2);
  const double excluded_px2 = 2 * min_log_odds_of_turn * noise_px * noise_px;
  if (open_to_rival && workspace.progress.rival_excess_px2 < excluded_px2) {
    result.verdict = TwoViewVerdict::ill_conditioned;
    result.sigma_rotation_rad = result.sigma_direction_rad = std::numeric_limits<double>::infinity();
  }
}

}  // namespace

Status begin_two_view(const PointPairs& pairs, const CameraModel& camera_a, const CameraModel& camera_b,
                      const RansacParams& params, TwoViewWorkspace& workspace, InlierMask& inliers,
                      TwoViewResult& result) {
  result = {};
  inliers.clear();
  static_cast<void>(inliers.resize(pairs.size()));
  ILP_TRY(validate(camera_a));
  ILP_TRY(validate(camera_b));
  ILP_TRY(validate(params));
  normalise_pairs(pairs, intrinsics_of(camera_a), intrinsics_of(camera_b), params.seed, workspace.pairs);
  TwoViewProgress& now = workspace.progress;
  now.part = TwoViewProgress::Part::search;
  now.plane_found = false;
  now.rival_excess_px2 = std::numeric_limits<double>::infinity();
  begin_ransac(EssentialProblem{workspace.pairs, params.threshold_px, workspace.selected}, workspace.pairs, params,
               now.poses);
  return {};
}

bool two_view_slice(const CameraModel& camera_a, const CameraModel& camera_b, const RansacParams& params,
                    TwoViewWorkspace& workspace, InlierMask& inliers, TwoViewResult& result) {
  using Part = TwoViewProgress::Part;
  TwoViewProgress& now = workspace.progress;
  switch (now.part) {
    case Part::search: {
      EssentialProblem problem{workspace.pairs, params.threshold_px, workspace.selected};
      if (ransac_slice(problem, workspace.pairs, params, trials_of_a_slice, now.poses)) return true;
      now.part = now.poses.report.found ? Part::support : Part::turn;
      if (now.part == Part::turn) begin_homography(workspace.pairs, params, workspace.selected, now.planes);
      return true;
    }
    case Part::support:
      gather_support(params, workspace);
      now.part = Part::plane;
      return true;
    case Part::plane:
      if (homography_slice(workspace.subset, params, workspace.subset_selected, now.planes)) return true;
      now.plane_found = end_homography(workspace.subset, params, workspace.subset_selected, now.planes, now.homography);
      now.part = Part::compare;
      return true;
    case Part::compare: {
      compare_with_plane(camera_b, params, workspace);
      NarrowMotion motion;
      now.part = is_narrow(params, workspace, motion) ? Part::mirror : Part::judge;
      return true;
    }
    case Part::mirror:
      compare_turns(params, workspace);
      now.part = Part::judge;
      return true;
    case Part::turn:
      if (homography_slice(workspace.pairs, params, workspace.selected, now.planes)) return true;
      explain_by_rotation(params, workspace, inliers, result);
      break;
    case Part::judge:
      describe_pose(camera_a, camera_b, params, workspace, inliers, result);
      break;
  }
  return false;
}

Status estimate_two_view(const PointPairs& pairs, const CameraModel& camera_a, const CameraModel& camera_b,
                         const RansacParams& params, TwoViewWorkspace& workspace, InlierMask& inliers,
                         TwoViewResult& result) {
  ILP_TRY(begin_two_view(pairs, camera_a, camera_b, params, workspace, inliers, result));
  // bound: `max_trials` of each model
  while (two_view_slice(camera_a, camera_b, params, workspace, inliers, result)) {
  }
  return {};
}

}  // namespace ilp
