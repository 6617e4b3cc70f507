// The text form of one window of bundle adjustment:
//   ncam npts nobs
//   fx fy cx cy
//   cam pt u v                  nobs lines, ideal px
//   fixed rx ry rz tx ty tz     ncam lines, x_cam = R X + t with R the rotation of |r| rad about r
//   X Y Z                       npts lines
#pragma once

#include <filesystem>

#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"

namespace ilp::lab {

/// std::runtime_error names line and cause; sizes over the flight limits are refused with the limit's name.
void read_window(const std::filesystem::path& path, BundleProblem& problem);
void write_window(const std::filesystem::path& path, const BundleProblem& problem);

}  // namespace ilp::lab
