// Parameters of the dense matcher, with a reason for each default.
#pragma once

#include <cstdint>

#include "cfg/choices.hpp"

namespace ilp {

/// Matching cost of a correlation of 0 or less; a correlation of 1 costs 0.
inline constexpr int max_matching_cost = 64;

struct StereoParams {
  StereoMatcherChoice matcher = StereoMatcherChoice::semi_global;
  /// 1 to 4: a small NCC window keeps edges sharp; the paths aggregate support over more pixels.
  int window_radius = 2;
  /// Standard deviation of the sensor noise, grey levels: damps the NCC of windows without texture.
  double noise_grey = 1.0;
  /// Penalty of a large disparity step across a strong image edge, where depth edges are; 10 to 140.
  int min_large_step_penalty = 24;
  /// Least NCC of the chosen disparity, averaged over a few pixels; a larger value loses weak texture.
  double min_ncc = 0.3;
  /// Lead of a unique disparity over all others but its direct neighbours: 1/1000 of max_matching_cost per path.
  int uniqueness_permille = 20;
  double min_texture_grey = 0.8;  ///< a window has no texture if its grey values have a smaller standard deviation
  /// With semi_global: applies the ordering constraint, which holds on terrain but not beside thin objects.
  bool keep_order = true;
  std::int32_t min_segment_px = 60;  ///< smaller connected segments are removed
  /// A disparity at the edge of the view may differ from disparities further inside by at most this.
  double border_step_px = 0.8;
  /// Number of a gap pixel's neighbours that must agree on a disparity before it is tried; 0: no recovery.
  int recovery_neighbours = 3;
  double recovery_min_ncc = 0.4;  ///< least NCC of a recovered pixel
  /// A recovered disparity may differ from the median of its neighbours by at most this.
  double recovery_step_px = 0.6;
  /// Neighbours that differ by more belong to two surfaces; 0: pixels beside edges are not decided again.
  double surface_step_px = 2;
  /// Largest distance from a gap pixel to the matches that support it; 0: no gap is supported.
  std::int32_t gap_reach_px = 32;
  bool coarse_to_fine = true;  ///< search only disparities near those that a map at a quarter of the resolution has
};

}  // namespace ilp
