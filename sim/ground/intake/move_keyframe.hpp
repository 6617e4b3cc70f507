// Takes a keyframe to another world: its pose, points and depths with their errors.
#pragma once

#include "fsw/vision/geometry/similarity.hpp"
#include "sim/ground/intake/flight_model.hpp"

namespace ilp::intake {

/// Covariances turn and grow with the pose.
void move(const Similarity& by, PoseRecord& pose);
void move(const Similarity& by, StructurePoint& point);
/// The pose, the points that became final with it, the scale of depths that are not decoded yet, and the depth of the
/// ground point of its fix.
void move(const Similarity& by, Keyframe& keyframe);

}  // namespace ilp::intake
