// Parameters of the dense matcher, with a reason for each default.
#pragma once

#include <cstdint>

#include "cfg/choices.hpp"

namespace ilp {

/// Costs are in units of 1 / max_matching_cost of a correlation of one.
inline constexpr int max_matching_cost = 64;

struct StereoParams {
  StereoMatcherChoice matcher = StereoMatcherChoice::semi_global;
  int window_radius = 2;            ///< 1 to 4: a small NCC window keeps edges sharp, and the paths bring the support
  double noise_grey = 1.0;          ///< sensor noise, grey levels: damps the NCC of flat windows
  int min_large_step_penalty = 24;  ///< of paths across a strong image edge, where depth edges are; 10 to 140
  double min_ncc = 0.3;           ///< least mean NCC of the chosen disparity over a few pixels; more loses weak texture
  int uniqueness_permille = 20;   ///< the best path must cost less than any other by this share of max_matching_cost
  double min_texture_grey = 0.8;  ///< a window whose grey values have a smaller standard deviation is blank
  bool keep_order = true;  ///< semi_global: the ordering constraint holds on terrain, but not beside thin objects
  std::int32_t min_segment_px = 60;  ///< smaller connected segments are removed
  double border_step_px = 0.8;  ///< largest difference of a disparity at the edge of the view from those further inside
  int recovery_neighbours = 3;  ///< of a gap, that must agree on the disparity to be tried; 0: no recovery
  double recovery_min_ncc = 0.4;   ///< least NCC at the gap
  double recovery_step_px = 0.6;   ///< largest difference of the disparity found from that of the neighbours
  double surface_step_px = 2;      ///< neighbours that differ by more are of two surfaces; 0: no pixel chooses again
  std::int32_t gap_reach_px = 32;  ///< distance to the matches on both sides that support a gap; 0: none is supported
  bool coarse_to_fine = true;      ///< search only where a map at a quarter of the resolution has the ground
};

}  // namespace ilp
