// Scratch memory of Sequence, several megabytes: keep it in static memory.
#pragma once

#include <array>
#include <cstdint>

#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"
#include "fsw/vision/multiview/resection.hpp"
#include "fsw/vision/multiview/sequence_covariance.hpp"
#include "fsw/vision/multiview/track.hpp"
#include "fsw/vision/multiview/window_problem.hpp"
#include "fsw/vision/twoview/robust/two_view_workspace.hpp"
#include "fsw/vision/twoview/two_view.hpp"

namespace ilp {

struct SequenceWorkspace {
  TwoViewWorkspace two_view;
  PointPairs pairs;
  InlierMask pair_inliers;
  PointViews views;
  ViewMask view_inliers;
  std::array<std::uint16_t, limits::max_matches> match_of_view;
  /// Per match: nonzero if the projection of its known point contradicts it.
  std::array<std::uint8_t, limits::max_matches> contradicts;
  TrackOfCorner track_of_corner;
  std::array<double, limits::max_matches> ratios;
  BundleProblem problem;
  WindowMap map;
  BundleAdjuster adjuster;
  StripCovarianceWorkspace errors;
};

}  // namespace ilp
