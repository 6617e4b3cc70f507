// Effects of a lens on light other than distortion.
#pragma once

#include "fsw/base/geometry.hpp"
#include "sim/host/image_io.hpp"
#include "sim/world/pixel_fan.hpp"

namespace ilp::world {

/// Share of the light that arrives: 1 at the principal point, 1 - `loss` in the corner farthest from it, falling with
/// the fourth power of the cosine of the field angle in between.
class Vignetting {
 public:
  Vignetting(const CameraModel& camera, double loss);
  [[nodiscard]] double share(const Direction& direction) const;

 private:
  double scale_;
};

/// Point spread: convolution with a Gaussian of `sigma_px`, cut off beyond four sigma. Beyond the image's edge
/// its last pixels go on.
void blur(host::Raster<float>& radiance, double sigma_px);

}  // namespace ilp::world
