// The bundle adjustment problem of a strip's newest window (decisions.md, 5), and the transfer of its result to the
// strip.
#pragma once

#include <array>
#include <cstdint>

#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"
#include "fsw/vision/multiview/sequence.hpp"

namespace ilp {

/// The cameras and tracks of the problem's cameras and points.
struct WindowMap {
  std::array<std::uint16_t, limits::max_bundle_cameras> camera;  ///< index into SequenceState::cameras
  std::array<std::uint16_t, limits::max_bundle_points> track;
  std::uint32_t left_out = 0;  ///< points that did not fit
};

/// Free cameras: the newest window_keyframes, but never the strip's first. Fixed cameras: older ones that share at
/// least min_resection_inliers points with them, in any case the newest of the older ones. Points: those that a free
/// camera sees, with their observations by all cameras of the problem. If only one fixed camera is left to determine
/// the scale, its distance to the next camera is held.
void build_window(const SequenceState& state, BundleProblem& problem, WindowMap& map);
/// Copies the poses of free cameras and the positions of points.
void store_window(const BundleProblem& problem, const WindowMap& map, SequenceState& state);

}  // namespace ilp
