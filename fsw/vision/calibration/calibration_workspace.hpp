// Scratch of SelfCalibration: some megabytes, keep it static.
#pragma once

#include <array>
#include <cstdint>

#include "fsw/vision/calibration/focal_refinement.hpp"
#include "fsw/vision/calibration/projective_reconstruction.hpp"

namespace ilp {

struct CalibrationWorkspace {
  ProjectiveWorkspace projective;
  VerificationWorkspace verification;
  std::array<std::uint16_t, limits::max_corners> track_of_corner;
};

}  // namespace ilp
