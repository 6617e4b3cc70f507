// The bundle adjustment problem of a strip's newest window (decisions.md, 5), and its result back into the strip.
#pragma once

#include <array>
#include <cstdint>

#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"
#include "fsw/vision/multiview/sequence.hpp"

namespace ilp {

/// Which camera and which track the cameras and points of the problem are.
struct WindowMap {
  std::array<std::uint16_t, limits::max_bundle_cameras> camera;  ///< index into SequenceState::cameras
  std::array<std::uint16_t, limits::max_bundle_points> track;
  std::uint32_t left_out = 0;  ///< points that did not fit
};

/// Free: the newest window_keyframes cameras, but never the strip's first. Fixed: older cameras that share at least
/// min_resection_inliers points with them, in any case the newest of the older ones. Points: those that a free camera
/// sees, with their observations by all cameras of the problem. Where only one fixed camera is left to tell the scale,
/// its distance to the next camera is held.
void build_window(const SequenceState& state, BundleProblem& problem, WindowMap& map);
/// Poses of free cameras and positions of points.
void store_window(const BundleProblem& problem, const WindowMap& map, SequenceState& state);

}  // namespace ilp
