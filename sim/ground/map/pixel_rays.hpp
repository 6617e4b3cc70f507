// The directions in which the pixels of a camera look.
#pragma once

#include "fsw/vision/geometry/camera.hpp"
#include "sim/host/raster.hpp"

namespace ilp::map {

struct Ray {
  float x = 0, y = 0;  ///< X/Z and Y/Z
};

/// Distortion is undone once per camera, not once per keyframe.
class PixelRays {
 public:
  const host::Raster<Ray>& of(const CameraModel& camera);

 private:
  CameraModel camera_;
  host::Raster<Ray> rays_;
};

}  // namespace ilp::map
