// How a model grows: units find their place in it one after the other, and it is adjusted as it grows.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/ground/model/model.hpp"
#include "sim/ground/model/placing.hpp"

namespace ilp::model {

/// Bounds on reprojection errors: while units are placed, after all have been adjusted once, and in the end.
inline constexpr double placing_px = 6, adjusted_px = 3, final_px = 1.5;

/// Triangulates, adjusts, and refuses what is off by more than `max_px`. `tolerance`: as in AdjustmentParams.
void adjust_in_steps(const Scene& scene, double max_px, Model& model, double tolerance = AdjustmentParams{}.tolerance);

inline constexpr double most_drift_px = 120;

/// A strip that has drifted sees its earlier ground many pixels from where its poses put it: adjusts the model in
/// bounds that begin at twice as many. Bounds that are wider than the drift let wrong sightings lead a model whose
/// strips are weakly connected into another minimum.
void close_loops(const Scene& scene, double drift_px, Model& model, double tolerance = AdjustmentParams{}.tolerance);

/// Places one unit after the other, that with most common tracks first, as long as one finds its place. `taken`: by
/// unit, not 0 if it stands in some model.
void place_all(const Scene& scene, const std::vector<Unit>& units, std::vector<std::uint8_t>& taken, Model& model);

}  // namespace ilp::model
