// What the dense matcher can be told, with a reason for each default.
#pragma once

#include <cstdint>

namespace ilp {

/// Costs are in units of 1 / max_matching_cost of a correlation of one.
inline constexpr int max_matching_cost = 64;

struct StereoParams {
  int window_radius = 2;         ///< of the NCC window, 1 to 4: small keeps edges sharp, the paths bring the support
  double noise_grey = 1.0;       ///< grey levels, sensor noise: damps the NCC of flat windows
  int out_of_view_cost = 30;     ///< of a match that the other image does not show: between a right and a chance match
  int small_step_penalty = 10;   ///< for a change of one px (slanted ground), at most 31
  int large_step_penalty = 160;  ///< for any larger change where the image is smooth, at most 160
  int min_large_step_penalty = 24;  ///< the same across a strong image edge, where depth edges are
  int edge_grey = 4;                ///< grey difference from which the large penalty falls, inversely
  double min_ncc = 0.3;  ///< of the chosen disparity over a few pixels, damped by the noise; more costs low texture
  int uniqueness_permille = 20;   ///< of the full matching cost, by which the best path cost must beat any other
  double min_texture_grey = 0.8;  ///< standard deviation of grey in the window: less is blank
  bool allow_one_px = true;       ///< left-right check: the right pixel may have the neighbouring disparity
  bool keep_order = true;         ///< ordering constraint: holds on terrain, not behind thin things in the foreground
  std::int32_t min_segment_px = 60;  ///< smaller connected segments are removed
  double segment_step_px = 1.5;      ///< disparity change that still connects neighbours
  double border_step_px = 0.8;       ///< at the edge of the view: of a disparity from those further inside
  int recovery_neighbours = 3;       ///< of the eight that must agree on a disparity to try it at a gap; 0: no recovery
  double recovery_min_ncc = 0.4;     ///< of the correlation there
  double recovery_step_px = 0.6;     ///< of what is found there from what the neighbours said
  double smoothing_step_px = 2.5;    ///< neighbours that differ by more do not average; 0 turns averaging off
  bool coarse_to_fine = true;        ///< search only where a map at a quarter of the resolution says that the ground is
  std::int32_t search_margin_px = 5;  ///< more on either side: what is too small for the coarse map
  double min_coarse_matched = 0.9;  ///< share of a tile that the coarse map must match, or the whole range is searched
};

}  // namespace ilp
