// The viewing rays of a camera's pixels, without distortion.
#pragma once

#include "fsw/vision/geometry/camera.hpp"
#include "sim/host/raster.hpp"

namespace ilp::map {

struct Ray {
  float x = 0, y = 0;  ///< X/Z and Y/Z in the camera frame
};

/// Keeps the rays of the camera that was used last: distortion is removed once per camera, not once per keyframe.
class PixelRays {
 public:
  /// One ray per pixel. The reference holds until the next call.
  const host::Raster<Ray>& of(const CameraModel& camera);

 private:
  CameraModel camera_;
  host::Raster<Ray> rays_;
};

}  // namespace ilp::map
