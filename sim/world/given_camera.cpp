#include "sim/world/given_camera.hpp"

#include <cmath>

#include "fsw/base/rng.hpp"

namespace ilp::world {

std::vector<Parameter> parameters(GivenCameraErrors& e) {
  return {
      {"focal_share", &e.focal_share, "", "error of the given focal length, as a share of it", -0.9, 10},
      {"centre_x_px", &e.centre_x_px, "px", "error of the given principal point along x", -10000, 10000},
      {"centre_y_px", &e.centre_y_px, "px", "error of the given principal point along y", -10000, 10000},
      {"k1", &e.k1, "", "error of the given radial distortion k1", -1, 1},
      {"k2", &e.k2, "", "error of the given radial distortion k2", -1, 1},
      {"p1", &e.p1, "", "error of the given tangential distortion p1", -0.1, 0.1},
      {"p2", &e.p2, "", "error of the given tangential distortion p2", -0.1, 0.1},
      {"random", &e.random, "", "factor on errors of all of these that are drawn from the seed; 0: none", 0, 10},
  };
}

CameraModel given_camera(const CameraModel& truth, const GivenCameraErrors& errors, std::uint64_t seed) {
  constexpr std::uint64_t stream = 0x61FE4CA;
  Rng rng(seed, stream);
  const auto drawn = [&](double sigma) {
    double sum = 0;
    for (int i = 0; i < 12; ++i) sum += rng.uniform();
    return errors.random * sigma * (sum - 6);  // twelve uniform numbers: nearly normal, variance 1
  };
  CameraModel out = truth;
  const double share = errors.focal_share + drawn(0.03);
  out.fx *= 1 + share;
  out.fy *= 1 + share;
  out.cx += errors.centre_x_px + drawn(4);
  out.cy += errors.centre_y_px + drawn(4);
  out.k1 += errors.k1 + drawn(0.02);
  out.k2 += errors.k2 + drawn(0.01);
  out.p1 += errors.p1 + drawn(0.0005);
  out.p2 += errors.p2 + drawn(0.0005);
  return out;
}

}  // namespace ilp::world
