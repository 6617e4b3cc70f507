// Corners of two images that show the same ground.
#pragma once

#include <memory>

#include "fsw/vision/features/harris.hpp"
#include "fsw/vision/features/harris_workspace.hpp"
#include "fsw/vision/features/matcher.hpp"
#include "fsw/vision/features/matcher_workspace.hpp"
#include "fsw/vision/overlap/overlap.hpp"
#include "fsw/vision/overlap/overlap_workspace.hpp"
#include "guest.hpp"

inline ilp::Corners corners_of(ilp::GrayView image) {
  static const auto workspace = std::make_unique<ilp::HarrisWorkspace>();
  ilp::Corners corners;
  check(ilp::detect_corners(image, {}, *workspace, corners), "corners");
  return corners;
}

/// Corners of b that were not detected, but tracked from a, are appended to `corners_b`.
inline ilp::Matches matches_of(ilp::GrayView a, const ilp::Corners& corners_a, ilp::GrayView b,
                               ilp::Corners& corners_b) {
  static const auto overlap_workspace = std::make_unique<ilp::OverlapWorkspace>();
  static const auto workspace = std::make_unique<ilp::MatcherWorkspace>();
  ilp::OverlapResult overlap;
  check(ilp::measure_overlap(a, b, {}, *overlap_workspace, overlap), "overlap");
  ilp::Matches matches;
  check(ilp::match_and_track_corners(a, corners_a, b, corners_b, overlap.plane_b_from_a, {}, *workspace, matches),
        "matches");
  return matches;
}
