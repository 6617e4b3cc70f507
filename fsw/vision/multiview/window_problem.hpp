// Builds the bundle adjustment problem of a strip's newest window (decisions.md, 5) and writes its result to the strip.
#pragma once

#include <array>
#include <cstdint>

#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"
#include "fsw/vision/multiview/sequence.hpp"

namespace ilp {

/// The strip's camera and track for each camera and point of the problem.
struct WindowMap {
  std::array<std::uint16_t, limits::max_bundle_cameras> camera;  ///< indices into SequenceState::cameras
  std::array<std::uint16_t, limits::max_bundle_points> track;
  std::uint32_t left_out = 0;  ///< number of points that exceeded the capacity of the problem
};

/// Builds the problem.
/// - Free cameras are the newest window_keyframes cameras, but never the strip's first one.
/// - Fixed cameras are the newest older camera, and other older cameras that share at least min_resection_inliers
///   points with the free ones.
/// - Points are those that a free camera sees, with their observations by all cameras of the problem.
/// If only one fixed camera is left to determine the scale, its distance to another camera is held.
void build_window(const SequenceState& state, BundleProblem& problem, WindowMap& map);
/// Copies the poses of the free cameras and the positions of the points to the strip.
void store_window(const BundleProblem& problem, const WindowMap& map, SequenceState& state);

}  // namespace ilp
