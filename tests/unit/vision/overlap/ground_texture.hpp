// Procedural ground for the overlap tests: large textures that repeat only at their own edge, looked at through known
// similarities. Made independently of the simulator's world and of the code under test.
#pragma once

#include <cstdint>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "fsw/base/rng.hpp"
#include "tests/support/read_image.hpp"

namespace ilp::test {

enum class Ground : std::uint8_t { fractal, dunes, craters, boulders, cells, count };

/// Square toroidal raster; values have mean 0 and standard deviation 1.
class GroundTexture {
 public:
  static constexpr int side = 1024;

  GroundTexture(Ground kind, std::uint64_t seed);
  /// Bilinear, x and y in texels, any finite value.
  [[nodiscard]] double at(double x, double y) const;

 private:
  std::vector<float> texels_;
};

/// Ground that repeats itself: a tile of `ground` of period x period texels.
struct Tiling {
  double period_x = 0, period_y = 0;  ///< texels; 0: does not repeat along this axis
};

struct Exposure {
  double mean = 120, contrast = 35;  ///< grey levels before the gain; contrast is one standard deviation of the ground
  double gain = 1, offset = 0;
  double noise = 0;     ///< grey levels, one sigma
  double vignette = 0;  ///< share of light lost in the corners
  double smear_px = 0;  ///< motion along x during the exposure
};

/// Each pixel is the mean of 2 x 2 samples inside it.
[[nodiscard]] Image look_at(const GroundTexture& ground, const Tiling& tiling, const Similarity2& ground_from_image,
                            std::int32_t width, std::int32_t height, const Exposure& exposure, Rng& rng);

/// Share of a's area that `b_from_a` sends into b, by counting evenly spread points (to 0.1 %).
[[nodiscard]] double counted_overlap(const Similarity2& b_from_a, std::int32_t width, std::int32_t height);

/// About the image centres: turn, scale, then shift.
[[nodiscard]] Similarity2 about_centre(double scale, double rotation_rad, double shift_x_px, double shift_y_px,
                                       std::int32_t width, std::int32_t height);

/// Turn, scale and direction as given; the length of the shift follows from the overlap wanted (0 to 1), as near as
/// turn and scale allow.
[[nodiscard]] Similarity2 with_overlap(double overlap, double scale, double rotation_rad, double direction_rad,
                                       std::int32_t width, std::int32_t height);

/// Gaussian, mean 0, sigma 1 (sum of twelve uniform numbers).
[[nodiscard]] double gaussian(Rng& rng);

}  // namespace ilp::test
