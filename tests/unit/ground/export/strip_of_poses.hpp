// A flight of one strip with poses and nothing else.
#pragma once

#include "sim/ground/intake/flight_model.hpp"

namespace ilp::test {

/// Keyframes 1 to 3 of strip 1, at x = 0, 8, 16, y = 2, z = 10.
[[nodiscard]] inline intake::Flight strip_of_poses(bool metres) {
  intake::Flight flight;
  flight.strips[1].id = 1;
  for (std::int64_t id = 1; id <= 3; ++id) {
    intake::Keyframe& keyframe = flight.keyframes[id];
    keyframe.id = id;
    keyframe.strip_id = 1;
    keyframe.name = "frame-" + std::to_string(id) + ".png";
    PoseRecord pose;
    pose.id = id;
    pose.strip_id = 1;
    pose.state = PoseState::final;
    pose.scale_source = metres ? ScaleSource::altimeter : ScaleSource::first_baseline;
    pose.centre[0] = 8.0 * static_cast<double>(id - 1);
    pose.centre[1] = 2;
    pose.centre[2] = 10;
    for (double& sigma : pose.sigma) sigma = 0.25;
    keyframe.pose = pose;
    flight.strips[1].keyframes.push_back(id);
  }
  return flight;
}

}  // namespace ilp::test
