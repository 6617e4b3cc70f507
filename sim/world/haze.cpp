#include "sim/world/haze.hpp"

#include "fsw/base/math.hpp"

namespace ilp::world {

Haze::Haze(double share, double scale_height_m, double camera_z_m)
    : scale_height_m_(scale_height_m), camera_z_m_(camera_z_m) {
  per_density_m_ = -det_log(1 - share) / (camera_z_m * mean_density(0));
}

double Haze::mean_density(double z_m) const {
  if (scale_height_m_ <= 0) return 1;
  const double column = (camera_z_m_ - z_m) / scale_height_m_;
  return (det_exp(-z_m / scale_height_m_) - det_exp(-camera_z_m_ / scale_height_m_)) / column;
}

double Haze::transmission(double z_m, double path_m) const {
  return det_exp(-per_density_m_ * mean_density(z_m) * path_m);
}

}  // namespace ilp::world
