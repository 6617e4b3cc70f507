#include "sim/ground/report/image_quality.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <system_error>

#include "sim/ground/intake/keyframe_rasters.hpp"
#include "sim/host/image_io.hpp"

namespace ilp::report {

double psnr_db(ImageView<const std::uint8_t> decoded, ImageView<const std::uint8_t> original,
               const host::Raster<std::uint8_t>& mask, bool inside) {
  const bool masked = mask.same_size(decoded.width, decoded.height);
  double squares = 0, pixels = 0;
  for (std::int32_t y = 0; y < decoded.height; ++y) {
    for (std::int32_t x = 0; x < decoded.width; ++x) {
      if ((!masked || mask.at(x, y) != 0) != inside) continue;
      const double difference = static_cast<double>(decoded.at(x, y)) - original.at(x, y);
      squares += difference * difference;
      ++pixels;
    }
  }
  if (pixels == 0) return std::numeric_limits<double>::quiet_NaN();
  return 10 * std::log10(255.0 * 255.0 * pixels / squares);
}

void measure_image_quality(const std::filesystem::path& folder, Report& report) {
  for (const auto& [id, keyframe] : report.flight.keyframes) {
    if (!keyframe.has_image()) continue;
    const std::filesystem::path path = folder / keyframe.name;
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) continue;
    try {
      const host::Raster<std::uint8_t> original = host::read_gray(path);
      const intake::KeyframeRasters rasters = intake::decode_products(keyframe).rasters;
      if (!rasters.image.same_size(original.width, original.height)) continue;
      report.image_quality[id] = {psnr_db(rasters.image.view(), original.view(), rasters.mask, true),
                                  psnr_db(rasters.image.view(), original.view(), rasters.mask, false)};
    } catch (const std::exception& fault) {
      report.flight.remarks.emplace_back(fault.what());
    }
  }
}

}  // namespace ilp::report
