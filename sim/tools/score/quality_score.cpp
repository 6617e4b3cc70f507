#include "sim/tools/score/quality_score.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <system_error>

#include "sim/ground/report/report.hpp"
#include "sim/host/image_io.hpp"

namespace ilp::score {
namespace {

void compare(const intake::Keyframe& keyframe, const std::filesystem::path& path, QualityScore& score,
             std::vector<std::string>& remarks) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error) || score.masked_pixels == 0) return;
  try {
    const host::Raster<std::uint8_t> original = host::read_gray(path);
    if (!keyframe.image.same_size(original.width, original.height)) {
      remarks.push_back(path.string() + ": " + std::to_string(original.width) + " x " +
                        std::to_string(original.height) + " pixels; the product has " +
                        std::to_string(keyframe.image.width) + " x " + std::to_string(keyframe.image.height));
      return;
    }
    const double db = report::psnr_db(keyframe.image.view(), original.view(), keyframe.mask, true);
    score.compared_pixels = score.masked_pixels;
    score.squares =
        std::isinf(db) ? 0 : full_scale_squared * static_cast<double>(score.compared_pixels) / std::pow(10.0, db / 10);
  } catch (const std::exception& fault) {
    remarks.emplace_back(fault.what());
  }
}

}  // namespace

double QualityScore::psnr_db() const {
  if (compared_pixels == 0) return unknown;
  return 10 * std::log10(full_scale_squared * static_cast<double>(compared_pixels) / squares);
}

double QualityScore::image_bytes_per_masked_pixel() const {
  return masked_pixels == 0 ? unknown : static_cast<double>(image_bytes) / static_cast<double>(masked_pixels);
}

void QualityScore::add(const QualityScore& other) {
  image_bytes += other.image_bytes;
  depth_bytes += other.depth_bytes;
  masked_pixels += other.masked_pixels;
  squares += other.squares;
  compared_pixels += other.compared_pixels;
}

std::map<std::int64_t, QualityScore> score_quality(const intake::Flight& flight, const std::filesystem::path& images,
                                                   std::vector<std::string>& remarks) {
  std::map<std::int64_t, QualityScore> scores;
  for (const auto& [id, keyframe] : flight.keyframes) {
    const auto& image = keyframe.product(ProductKind::image);
    if (!image || keyframe.image.empty()) continue;
    QualityScore& score = scores[id];
    score.image_bytes = image->bytes;
    if (const auto& depth = keyframe.product(ProductKind::depth)) score.depth_bytes = depth->bytes;
    // Without its mask an image is taken as a whole, as psnr_db does.
    const bool masked = keyframe.mask.same_size(keyframe.image.width, keyframe.image.height);
    score.masked_pixels =
        masked ? keyframe.mask.samples.size() -
                     static_cast<std::size_t>(std::count(keyframe.mask.samples.begin(), keyframe.mask.samples.end(), 0))
               : keyframe.image.samples.size();
    if (!images.empty()) compare(keyframe, images / keyframe.name, score, remarks);
  }
  return scores;
}

}  // namespace ilp::score
