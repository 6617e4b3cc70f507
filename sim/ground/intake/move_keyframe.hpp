// Transforms a keyframe to another world by a similarity: pose, points and depths, with their errors.
#pragma once

#include "fsw/vision/geometry/similarity.hpp"
#include "sim/ground/intake/flight_model.hpp"

namespace ilp::intake {

/// Transforms a pose and its covariances.
void move(const Similarity& by, PoseRecord& pose);
void move(const Similarity& by, StructurePoint& point);
/// Transforms a keyframe: its pose, the points that became final with it, the scale of its coded depths, and the ground
/// depth of its fix. Rasters that are decoded already do not change.
void move(const Similarity& by, Keyframe& keyframe);

}  // namespace ilp::intake
