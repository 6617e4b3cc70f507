// Effects of a lens on light: vignetting and point spread. Distortion is in pixel_fan.hpp.
#pragma once

#include "fsw/base/geometry.hpp"
#include "sim/host/image_io.hpp"
#include "sim/world/pixel_fan.hpp"

namespace ilp::world {

/// Share of the light that reaches the sensor: 1 at the principal point, 1 - `loss` in the corner farthest from it, in
/// between by the fourth power of the cosine of the field angle.
class Vignetting {
 public:
  Vignetting(const CameraModel& camera, double loss);
  [[nodiscard]] double share(const Direction& direction) const;

 private:
  double scale_;
};

/// Point spread: convolution with a Gaussian of `sigma_px`, truncated at four sigma. Edge pixels are repeated beyond
/// the edges.
void blur(host::Raster<float>& radiance, double sigma_px);

}  // namespace ilp::world
