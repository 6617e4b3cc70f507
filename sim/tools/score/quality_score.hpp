// Scores the quality of image products, and counts their bytes.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"

namespace ilp::score {

/// Square of the largest grey value, the reference of a PSNR.
inline constexpr double full_scale_squared = 255.0 * 255.0;

/// Quality of the products of one keyframe, or of several keyframes together.
struct QualityScore {
  std::size_t image_bytes = 0, depth_bytes = 0;  ///< sizes of the products including metadata
  std::size_t masked_pixels = 0;                 ///< pixels in the masks; all pixels of an image without a mask
  double squares = 0;                            ///< sum of squared grey differences of the compared pixels
  std::size_t compared_pixels = 0;               ///< masked pixels of keyframes with an original image

  /// NaN if nothing was compared, infinity if all compared pixels are equal.
  [[nodiscard]] double psnr_db() const;
  /// NaN without masked pixels.
  [[nodiscard]] double image_bytes_per_masked_pixel() const;
  void add(const QualityScore& other);
};

/// Scores by keyframe id, for keyframes with an image product. `images` is the folder of the original images, which
/// have the names of the keyframes; if empty, only sizes are scored. Originals that cannot be read or have another size
/// are not compared, and get a line in `remarks`.
[[nodiscard]] std::map<std::int64_t, QualityScore> score_quality(const intake::Flight& flight,
                                                                 const std::filesystem::path& images,
                                                                 std::vector<std::string>& remarks);

}  // namespace ilp::score
