// The same adjustment by Ceres Solver, as a peer in tests. Built only where Ceres is installed. No type of Eigen stands
// here: flight code compiles Eigen with other settings than Ceres does.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace ilp::model::test {

struct PeerCamera {
  std::array<double, 9> cam_from_world;  ///< rotation, row-major
  std::array<double, 3> centre;
  double fx = 0, fy = 0, cx = 0, cy = 0;
};

struct PeerObservation {
  std::size_t camera = 0, point = 0;
  double x = 0, y = 0;
};

struct PeerDepth {
  std::size_t camera = 0, point = 0;
  double inverse_depth = 0, sigma = 0;
};

struct PeerProblem {
  std::vector<PeerCamera> cameras;
  std::vector<std::array<double, 3>> points;
  std::vector<PeerObservation> observations;
  std::vector<PeerDepth> depths;
  std::size_t anchor = 0;
  int component = 0;  ///< of the anchor's centre; it stays where it is, as the first camera does
};

/// Half the sum of losses and squares at the minimum. Moves the centres.
double adjust_with_ceres(PeerProblem& problem, double robust_px);

}  // namespace ilp::model::test
