// Reference cameras of the recorded strips and the synthetic textures of the image tests.
#pragma once

#include <string>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "tests/support/read_image.hpp"

namespace ilp::test {

/// One line of a data set's cameras.txt: x_cam = R (X - C), no distortion.
struct StripImage {
  std::string name;
  CameraModel camera;
  double rotation[3][3] = {};  ///< cam_from_world, row-major
  double centre[3] = {};
};

/// `folder` inside data_root, such as "aerial_caliterra_a"; empty when the data are absent.
[[nodiscard]] std::vector<StripImage> read_strip(const std::string& folder);
[[nodiscard]] Image read_strip_image(const std::string& folder, const std::string& name);

/// Distance in px of (xb, yb) to the epipolar line of (xa, ya), and of the way back, averaged.
[[nodiscard]] double epipolar_distance(const StripImage& a, const StripImage& b, double xa, double ya, double xb,
                                       double yb);

/// An endless landscape of value noise over several octaves (amplitude falls slowly with the wavelength), band-limited
/// to `finest_px`, so that any point of it is known without interpolating an image. Mean 128.
[[nodiscard]] double fractal_texture(double x, double y, double finest_px, std::uint64_t seed);

/// The landscape seen by a camera whose pixel p looks at world_from_image * p; `noise` is the standard deviation added.
[[nodiscard]] Image render_texture(std::int32_t width, std::int32_t height, const Similarity2& world_from_image,
                                   double gain, double offset, double noise, std::uint64_t seed);

[[nodiscard]] Similarity2 compose(const Similarity2& c_from_b, const Similarity2& b_from_a);
[[nodiscard]] Similarity2 inverse(const Similarity2& b_from_a);
void apply(const Similarity2& b_from_a, double xa, double ya, double& xb, double& yb);

}  // namespace ilp::test
