// Haze between the ground and the camera: contrast falls with the length of the way through it (H. Koschmieder's law of
// visibility, 1924: L = L0 e^-tau + sky (1 - e^-tau)). The sky's light is that of level ground of mean albedo.
#pragma once

namespace ilp::world {

class Haze {
 public:
  /// `share`: of the light from level ground (z = 0) straight below a camera at `camera_z_m` that is replaced by the
  /// sky's, 0 to below 1. Density falls as exp(-z / scale height), or not at all for a scale height of 0.
  Haze(double share, double scale_height_m, double camera_z_m);

  /// Share of the light from the height `z_m` that reaches the camera over `path_m`.
  [[nodiscard]] double transmission(double z_m, double path_m) const;
  /// The part of a radiance that the camera receives.
  [[nodiscard]] double seen(double radiance, double z_m, double path_m) const {
    constexpr double sky = 1;
    return sky + (radiance - sky) * transmission(z_m, path_m);
  }

 private:
  /// Haze in a vertical column from the camera down to z, per metre of the column.
  [[nodiscard]] double mean_density(double z_m) const;

  double scale_height_m_;
  double camera_z_m_;
  double per_density_m_ = 0;
};

}  // namespace ilp::world
