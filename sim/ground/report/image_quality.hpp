// Compares decoded images with the originals.
#pragma once

#include <filesystem>

#include "sim/ground/report/report.hpp"

namespace ilp::report {

/// PSNR of 8-bit images over the pixels where `mask` (may be empty: everywhere) is set, or not set. NaN when there are
/// no such pixels, infinity when they are all exact.
[[nodiscard]] double psnr_db(ImageView<const std::uint8_t> decoded, ImageView<const std::uint8_t> original,
                             const host::Raster<std::uint8_t>& mask, bool inside);

/// Compares all keyframes that have an original FOLDER/NAME of the same size; an unreadable original becomes a remark.
void measure_image_quality(const std::filesystem::path& folder, Report& report);

}  // namespace ilp::report
