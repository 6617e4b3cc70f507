// Grows a model: places units in it one after the other, and adjusts it repeatedly.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/ground/model/model.hpp"
#include "sim/ground/model/placing.hpp"

namespace ilp::model {

/// Largest reprojection errors of inliers: while units are placed, after a first adjustment of all, and at the end.
inline constexpr double placing_px = 6, adjusted_px = 3, final_px = 1.5;

/// Triangulates new points, adjusts the model, and refuses sightings with errors above `max_px`. `tolerance`: as in
/// AdjustmentParams.
void adjust_in_steps(const Scene& scene, double max_px, Model& model, double tolerance = AdjustmentParams{}.tolerance);

/// Callers of close_loops limit `drift_px` to this.
inline constexpr double most_drift_px = 120;

/// Corrects the drift of a strip that sees earlier ground again. `drift_px`: error with which its poses project that
/// ground. Adjusts the model with decreasing bounds (adjust_in_steps), from twice the drift down to placing_px. Wider
/// bounds would let wrong sightings lead a weakly connected model into another minimum. `tolerance`: as in
/// AdjustmentParams.
void close_loops(const Scene& scene, double drift_px, Model& model, double tolerance = AdjustmentParams{}.tolerance);

/// Places units in the model, next always the one with most tracks in common with it, until no other can be placed.
/// Adjusts the model when it has grown. `taken`: for each unit, not 0 if it is in a model; is updated.
void place_all(const Scene& scene, const std::vector<Unit>& units, std::vector<std::uint8_t>& taken, Model& model);

}  // namespace ilp::model
