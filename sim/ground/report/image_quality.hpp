// How well the decoded images show what the camera saw.
#pragma once

#include <filesystem>

#include "sim/ground/report/report.hpp"

namespace ilp::ground {

/// PSNR of 8-bit images over the pixels where `mask` (may be empty: everywhere) is set, or not set. NaN when there are
/// no such pixels, infinity when they are all exact.
[[nodiscard]] double psnr_db(ImageView<const std::uint8_t> decoded, ImageView<const std::uint8_t> original,
                             const Raster<std::uint8_t>& mask, bool inside);

/// Against the originals FOLDER/NAME of all keyframes that have one of the same size; unreadable ones become remarks.
void measure_image_quality(const std::filesystem::path& folder, Report& report);

}  // namespace ilp::ground
