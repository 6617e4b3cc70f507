// The quality of image products and the bytes that it costs.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"

namespace ilp::score {

/// The square of the largest grey value, of which a PSNR counts the differences.
inline constexpr double full_scale_squared = 255.0 * 255.0;

/// The quality of one keyframe's products, or of many keyframes' together.
struct QualityScore {
  std::size_t image_bytes = 0, depth_bytes = 0;  ///< of the products with metadata and all
  std::size_t masked_pixels = 0;                 ///< inside the mask of keyframes with an image product
  double squares = 0;                            ///< squared grey differences inside the mask
  std::size_t compared_pixels = 0;               ///< of `masked_pixels`: where the original is at hand

  /// NaN where nothing was compared, infinity where all is exact.
  [[nodiscard]] double psnr_db() const;
  [[nodiscard]] double image_bytes_per_masked_pixel() const;
  void add(const QualityScore& other);
};

/// Scores by keyframe with an image product; originals are FOLDER/NAME (the folder may be empty: sizes only). What
/// cannot be read or has another size is not compared, and is listed in `remarks`.
[[nodiscard]] std::map<std::int64_t, QualityScore> score_quality(const intake::Flight& flight,
                                                                 const std::filesystem::path& images,
                                                                 std::vector<std::string>& remarks);

}  // namespace ilp::score
