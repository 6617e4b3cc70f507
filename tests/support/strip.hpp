// Reads recorded strips with their reference cameras, and draws the synthetic textures of the image tests.
#pragma once

#include <string>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "tests/support/read_image.hpp"

namespace ilp::test {

/// Image of a strip, from a line of the data set's cameras.txt. A point X of the world is at R (X - C) in the camera
/// frame. There is no distortion.
struct StripImage {
  std::string name;
  CameraModel camera;
  double rotation[3][3] = {};  ///< R, cam_from_world, row-major
  double centre[3] = {};       ///< C, in the world frame
};

/// Reads the images' cameras of the strip `folder` inside data_root, such as "aerial_caliterra_a". Empty if there are
/// no such data.
[[nodiscard]] std::vector<StripImage> read_strip(const std::string& folder);
[[nodiscard]] Image read_strip_image(const std::string& folder, const std::string& name);

/// Returns the mean of two distances in px: that of (xb, yb) from the epipolar line of (xa, ya), and that of (xa, ya)
/// from the epipolar line of (xb, yb).
[[nodiscard]] double epipolar_distance(const StripImage& a, const StripImage& b, double xa, double ya, double xb,
                                       double yb);

/// Returns the grey value at (x, y) of an unbounded texture: value noise of several octaves with wavelengths from
/// `finest_px` on, whose amplitude falls slowly with the wavelength. The mean is 128. The value is exact at any point,
/// because no image is interpolated.
[[nodiscard]] double fractal_texture(double x, double y, double finest_px, std::uint64_t seed);

/// Renders the texture as seen by a camera whose pixel p looks at world_from_image * p. The grey value is gain *
/// texture + offset with nearly Gaussian noise of the standard deviation `noise`.
[[nodiscard]] Image render_texture(std::int32_t width, std::int32_t height, const Similarity2& world_from_image,
                                   double gain, double offset, double noise, std::uint64_t seed);

[[nodiscard]] Similarity2 compose(const Similarity2& c_from_b, const Similarity2& b_from_a);
[[nodiscard]] Similarity2 inverse(const Similarity2& b_from_a);
void apply(const Similarity2& b_from_a, double xa, double ya, double& xb, double& yb);

}  // namespace ilp::test
