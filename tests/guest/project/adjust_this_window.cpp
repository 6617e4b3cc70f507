// adjust_this_window: five cameras and 200 points, disturbed, return to where their exact observations put them.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"

int main() {
  using namespace ilp;
  const auto truth = [](std::size_t i, int axis) {
    return std::sin(12.9898 * static_cast<double>(3 * i) + axis) * (axis == 2 ? 1 : 5);
  };
  const auto problem = std::make_unique<BundleProblem>();
  for (std::uint16_t c = 0; c < 5; ++c) {
    BundleCamera camera{{{1, 0, 0, 0}, {1.5 * c, 0, -10}}, 500, 500, 319.5, 239.5, c < 2};
    (void)problem->cameras.push_back(camera);
    for (std::uint16_t p = 0; p < 200; ++p) {
      const double depth = truth(p, 2) + 10, x = truth(p, 0) - 1.5 * c;
      (void)problem->observations.push_back({c, p, 319.5 + 500 * x / depth, 239.5 + 500 * truth(p, 1) / depth});
    }
    if (c >= 2) problem->cameras.back().pose.centre[c % 3] += 0.05;
  }
  for (std::uint16_t p = 0; p < 200; ++p) {
    (void)problem->points.push_back({{truth(p, 0) + 0.02, truth(p, 1) - 0.02, truth(p, 2) + 0.05}});
  }
  const auto adjuster = std::make_unique<BundleAdjuster>();
  BundleResult result;
  const Status status = adjuster->run(*problem, BundleParams{}, result);
  double largest = 0;
  for (std::size_t p = 0; p < 200; ++p) {
    for (int axis = 0; axis < 3; ++axis) {
      largest = std::max(largest, std::fabs(problem->points[p].position[axis] - truth(p, axis)));
    }
  }
  std::printf("%s: rms %.3g px -> %.3g px, largest error of a point %.3g\n", status_name(status.code),
              result.initial_rms_px, result.final_rms_px, largest);
  return status.ok() && largest < 1e-6 ? 0 : 1;
}
